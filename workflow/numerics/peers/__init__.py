"""Other ways to the same force, to compare with: a module each, found by being here.

A module that is compared has ``periodic_force`` and says in ``METHODS``, by the key of each method,
its path of refinement: from a film and a rung to the settings of ``periodic_force``, by a rule that
lets the parts of the error fall at the same rate. It may say ``installed``, whether it can be run
here, and ``DEVICE``, what it runs on. Colour and label are the figure's matter.
"""

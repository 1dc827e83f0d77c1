"""The two ways a command can end early, each with a message written for the reader."""


class InputError(Exception):
    """What was given is wrong; the message names the file and the place, and what is allowed.

    The command line prints the message without a traceback and exits with status 2.
    """


class RunError(Exception):
    """The work itself could not be completed, for instance because a scene did not converge.

    The command line prints the message without a traceback and exits with status 1.
    """

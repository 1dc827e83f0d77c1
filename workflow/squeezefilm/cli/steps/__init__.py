"""Steps of the workflow: plans, fits and designs."""

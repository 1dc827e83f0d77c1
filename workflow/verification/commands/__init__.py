"""Steps of the workflow: the solver examined."""

"""Steps of the workflow: what the paper alone has."""

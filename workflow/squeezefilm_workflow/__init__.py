"""Code that the scripts of the workflow's rules share."""

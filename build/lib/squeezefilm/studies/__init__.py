"""A study: its configuration, the space of its experiments, its plans."""

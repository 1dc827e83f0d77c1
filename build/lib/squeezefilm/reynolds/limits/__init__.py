"""Mean forces without a time step: limits of the film equation."""

"""Mean forces without a time step: expansions of the film equation at large squeeze number."""

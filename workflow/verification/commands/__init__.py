"""The solver examined."""

"""Inertia of the gas as a term of the solver, examined on random scenes."""

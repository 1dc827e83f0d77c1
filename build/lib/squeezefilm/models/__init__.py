"""The empirical force models: formulas, their fits, their errors and their use."""

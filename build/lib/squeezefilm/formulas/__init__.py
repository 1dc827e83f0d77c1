"""Arithmetic that people write: parsed, differentiated, its units inferred."""

"""Answers beside the mean force, from the same periodic state: see docs/outputs.md."""

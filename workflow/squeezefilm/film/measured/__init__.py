"""Profiles measured by a scanning vibrometer, made smooth with known errors."""

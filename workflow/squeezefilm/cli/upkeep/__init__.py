"""Upkeep of an installation and its results."""

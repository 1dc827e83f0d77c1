"""Squeeze-film forces from the Reynolds equation, and empirical models of them."""

__version__ = "0.1.0"

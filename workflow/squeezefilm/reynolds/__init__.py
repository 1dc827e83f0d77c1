"""The Reynolds equation solved: ``solve(scenes, tolerance=...)`` is the only door."""

from squeezefilm.reynolds.solver import Solution, solve

__all__ = ["Solution", "solve"]

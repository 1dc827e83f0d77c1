"""The Reynolds equation solved: ``solve(scenes, tolerance=...)`` is the only door."""

from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.solver import solve

__all__ = ["Solution", "solve"]

"""The Reynolds equation solved: ``solve(scenes, tolerance=...)`` is the only door."""

from squeezefilm.reynolds.solver import solve
from squeezefilm.solution import Solution

__all__ = ["Solution", "solve"]

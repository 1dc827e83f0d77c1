"""Figure 10: the first optimal pattern."""

from squeezefilm.figures.pattern import COLUMNS, draw

__all__ = ["COLUMNS", "draw"]

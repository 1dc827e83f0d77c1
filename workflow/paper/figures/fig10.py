"""Figure 10: the first optimal pattern."""

from paper.figures.pattern import COLUMNS, draw

__all__ = ["COLUMNS", "draw"]

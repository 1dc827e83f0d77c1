"""Figure 11: the second optimal pattern; says so where the searches found none."""

from paper.figures.pattern import COLUMNS, draw

__all__ = ["COLUMNS", "draw"]

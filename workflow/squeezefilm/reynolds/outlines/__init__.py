"""Fingers that are no rectangles, on a grid in the coordinates of their outline."""

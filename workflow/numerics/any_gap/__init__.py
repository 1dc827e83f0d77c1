"""Travelling waves, tilted and bulging rectangles, ellipses: extreme films of theirs."""

"""The film under an infinitely long strip, from the Reynolds equation to resolved profiles."""

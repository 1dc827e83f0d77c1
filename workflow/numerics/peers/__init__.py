"""Other ways to the same force, to compare with."""

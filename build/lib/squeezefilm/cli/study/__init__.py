"""A study of your own."""

"""Outputs of any study: figures, pages, the explorer, the check."""

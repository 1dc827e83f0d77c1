"""What any study shows: figures, pages, the explorer, the check."""

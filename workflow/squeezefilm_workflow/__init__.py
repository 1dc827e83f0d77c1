"""What the rules of the workflow share: the start of their scripts."""

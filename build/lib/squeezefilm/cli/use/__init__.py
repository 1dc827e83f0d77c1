"""Use: one force, one field, one model."""

"""Pieces of work on a whole study, one for each command that does one."""

"""Files, tables, units and what a job leaves: the bottom, which knows nothing above."""

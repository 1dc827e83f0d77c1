"""Commands that make figures and pages, and check a study."""

"""Steps of the workflow: figures and pages, and the check of a study."""

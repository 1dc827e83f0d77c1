"""The paper's figures: a module each, as `reporting.figures` says."""

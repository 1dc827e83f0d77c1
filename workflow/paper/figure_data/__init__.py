"""The tables of the paper's figures."""

"""The paper's figures, each drawn from its one table."""

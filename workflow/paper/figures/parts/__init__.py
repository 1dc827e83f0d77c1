"""What several of the paper's figures share."""

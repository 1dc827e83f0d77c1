"""Are forces as good as they say? Random films beside solves that share no node with them."""

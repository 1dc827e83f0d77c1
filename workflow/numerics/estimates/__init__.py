"""Are forces as good as they say? Random films, held against solves that share no node with them."""

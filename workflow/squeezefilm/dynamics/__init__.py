"""The film as others feel it: a spring under a load, and an answer to a changing amplitude."""

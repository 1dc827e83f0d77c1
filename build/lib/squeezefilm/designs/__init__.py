"""Which simulations to make: optimal designs, and the loop that they close."""

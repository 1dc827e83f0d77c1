"""Choice of simulations: optimal designs, and the loop of simulations and fits."""

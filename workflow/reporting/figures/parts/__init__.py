"""What several figures share: their style, planes, surfaces, and the tables behind them."""

"""Commands for what the paper alone has."""

"""Commands that the rules call, one after another."""

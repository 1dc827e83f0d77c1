"""Commands of the numerics stage."""

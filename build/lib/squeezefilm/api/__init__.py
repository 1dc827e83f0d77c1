"""What ``import squeezefilm`` gives, and what the command line is a thin face of."""

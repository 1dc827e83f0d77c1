"""The public names of ``import squeezefilm``, which the command line calls."""

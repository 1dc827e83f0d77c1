"""Published numbers beside exact solutions and the solver: ``snakemake verification``."""

# The whole paper: `snakemake` here runs it, `snakemake --list-target-rules` names its parts.

from snakemake.utils import min_version

min_version("9.20")


include: "workflow/Snakefile"


rule paper:
    default_target: True
    input:
        rules.all.input,
    message:
        "Everything of the study {STUDY} is made"

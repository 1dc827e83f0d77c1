# A whole study, the paper's by default: `snakemake` here runs it, `snakemake --list-target-rules`
# names its parts.

from snakemake.utils import min_version

min_version("9.20")


# The study is one of these files, which messages then name with their lines.
STUDY_FILES = workflow.configfiles


include: "workflow/Snakefile"


rule study:
    default_target: True
    input:
        rules.all.input,
    message:
        "Everything of the study {STUDY} is made"


# The same by the name that the paper's study has.
rule paper:
    input:
        rules.study.input,
    message:
        "Everything of the study {STUDY} is made"

# Accuracy, run time and stability of the solver: `snakemake verification`. Not part of the paper.

# Times are taken with nothing else running: such a rule asks for all cores.
ALONE = workflow.cores or 1


rule work_precision:
    input:
        fit="<results>/fits/screen.json",
    output:
        "<results>/numerics/work_precision.csv",
    threads: ALONE
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics"),
    message:
        "Error against run time of the solver and of other methods"
    script:
        "../scripts/work_precision.py"


rule stability:
    output:
        "<results>/numerics/stability.csv",
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics"),
    message:
        "Stiff and extreme films, each with a verdict"
    script:
        "../scripts/stability.py"


rule ablation:
    input:
        scenes=expand(f"{PLAN}/scenes.csv", plan=["screen", "four_factor"]),
    output:
        "<results>/numerics/ablation.csv",
    threads: ALONE
    resources:
        mem_mb=2000,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics", *FILM),
    message:
        "What simplifications save, and that they cost no accuracy"
    script:
        "../scripts/ablation.py"


rule published:
    output:
        "<results>/numerics/published.csv",
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics"),
    message:
        "Published numbers beside exact solutions and the solver"
    script:
        "../scripts/published.py"


rule verification:
    input:
        expand(
            "<results>/numerics/{table}.{format}",
            table=["work_precision", "stability", "published"],
            format=["csv", "png", "svg"],
        ),
        "<results>/numerics/ablation.csv",
    message:
        "Accuracy, run time and stability of the solver are known"

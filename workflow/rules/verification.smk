# Accuracy, run time and stability of the solver: `snakemake verification`. Not part of the paper.

# Times are taken with nothing else running: such a rule asks for all cores.
ALONE = workflow.cores or 1


rule work_precision:
    input:
        fit="<results>/fits/screen.json",
    output:
        "<results>/numerics/work_precision.csv",
    log:
        "<logs>/work_precision.log",
    benchmark:
        "<benchmarks>/work_precision.tsv"
    conda:
        "../../envs/workflow.yaml"
    threads: ALONE
    resources:
        mem_mb=growing(2000),
        runtime=growing(30),
    params:
        code=code_of("verification", "work_precision"),
        study=sections("solver", "numerics"),
    message:
        "Error against run time of the solver and of other methods"
    script:
        "../scripts/work_precision.py"


rule stability:
    output:
        "<results>/numerics/stability.csv",
    log:
        "<logs>/stability.log",
    benchmark:
        "<benchmarks>/stability.tsv"
    conda:
        "../../envs/workflow.yaml"
    resources:
        mem_mb=growing(2000),
        runtime=growing(30),
    params:
        code=code_of("verification", "stability"),
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
    log:
        "<logs>/ablation.log",
    benchmark:
        "<benchmarks>/ablation.tsv"
    conda:
        "../../envs/workflow.yaml"
    threads: ALONE
    resources:
        mem_mb=growing(2000),
    params:
        code=code_of("verification", "ablation"),
        study=sections("solver", "numerics", *FILM),
    message:
        "What simplifications save, and that they cost no accuracy"
    script:
        "../scripts/ablation.py"


rule published:
    output:
        "<results>/numerics/published.csv",
    log:
        "<logs>/published.log",
    benchmark:
        "<benchmarks>/published.tsv"
    conda:
        "../../envs/workflow.yaml"
    resources:
        mem_mb=growing(2000),
        runtime=growing(30),
    params:
        code=code_of("verification", "published"),
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

# Accuracy, run time and stability of the solver: `snakemake verification`. Not part of the paper.

# Times are taken with nothing else running: such a rule asks for all cores.
ALONE = workflow.cores or 1
# Threads of BLAS that wait for work count as processor time; every method gets one.
ONE_BLAS_THREAD = "OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MKL_NUM_THREADS=1"


rule work_precision:
    input:
        config=ancient(CONFIG_FILE),
        fit="<results>/fits/screen.json",
    output:
        "<results>/numerics/work_precision.csv",
    log:
        "<logs>/numerics/work_precision.log",
    benchmark:
        "<benchmarks>/numerics/work_precision.tsv"
    threads: ALONE
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics"),
        blas=ONE_BLAS_THREAD,
    message:
        "Error against run time of the solver and of other methods"
    shell:
        "{params.blas} python -m verification work-precision {input.fit:q} "
        "--config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule stability:
    input:
        config=ancient(CONFIG_FILE),
    output:
        "<results>/numerics/stability.csv",
    log:
        "<logs>/numerics/stability.log",
    benchmark:
        "<benchmarks>/numerics/stability.tsv"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics"),
        blas=ONE_BLAS_THREAD,
    message:
        "Stiff and extreme films, each with a verdict"
    shell:
        "{params.blas} POCL_MAX_PTHREAD_COUNT={threads} python -m verification stability "
        "--config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule ablation:
    input:
        config=ancient(CONFIG_FILE),
        scenes=expand("<results>/simulations/{plan}/scenes.csv", plan=["screen", "four_factor"]),
    output:
        "<results>/numerics/ablation.csv",
    log:
        "<logs>/numerics/ablation.log",
    benchmark:
        "<benchmarks>/numerics/ablation.tsv"
    threads: ALONE
    resources:
        mem_mb=2000,
    params:
        code=CODE["verification"],
        study=sections("solver", "numerics", *FILM),
        blas=ONE_BLAS_THREAD,
    message:
        "What leaving things out saves, and that it costs no accuracy"
    shell:
        "{params.blas} python -m verification ablation {input.scenes:q} --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule verification:
    input:
        expand(
            "<results>/{place}.{format}",
            place=[place for place in STAGES if place.startswith("numerics/")],
            format=["csv", "png", "svg"],
        ),
        "<results>/numerics/ablation.csv",
    message:
        "Accuracy, run time and stability of the solver are known"

# Accuracy and run time of the solver: `snakemake numerics`. Not part of the whole paper.

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
    conda:
        "../../envs/numerics.yaml"
    threads: ALONE
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["numerics"],
        study=sections("solver", "numerics"),
        blas=ONE_BLAS_THREAD,
    message:
        "Error against run time of the solver and of other methods"
    shell:
        "{params.blas} python -m numerics work-precision {input.fit:q} "
        "--config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule equal_error:
    input:
        table="<results>/numerics/work_precision.csv",
    output:
        "<results>/numerics/equal_error.csv",
    log:
        "<logs>/numerics/equal_error.log",
    localrule: True
    conda:
        "../../envs/numerics.yaml"
    params:
        code=CODE["numerics"],
    message:
        "How many times less time the solver takes at equal error"
    shell:
        "python -m numerics equal-error {input.table:q} --output {output:q} >{log:q} 2>&1"


rule stability:
    input:
        config=ancient(CONFIG_FILE),
    output:
        "<results>/numerics/stability.csv",
    log:
        "<logs>/numerics/stability.log",
    benchmark:
        "<benchmarks>/numerics/stability.tsv"
    conda:
        "../../envs/numerics.yaml"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["numerics"],
        study=sections("solver", "numerics"),
        blas=ONE_BLAS_THREAD,
    message:
        "Stiff and extreme films, each with a verdict"
    shell:
        "{params.blas} POCL_MAX_PTHREAD_COUNT={threads} python -m numerics stability "
        "--config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule left_out:
    input:
        config=ancient(CONFIG_FILE),
        scenes=expand(
            "<results>/simulations/{plan}/scenes.csv", plan=["screen", "four_factor_control"]
        ),
    output:
        "<results>/numerics/left_out.csv",
    log:
        "<logs>/numerics/left_out.log",
    benchmark:
        "<benchmarks>/numerics/left_out.tsv"
    conda:
        "../../envs/numerics.yaml"
    threads: ALONE
    resources:
        mem_mb=2000,
    params:
        code=CODE["numerics"],
        study=sections("solver", "numerics", *FILM),
        blas=ONE_BLAS_THREAD,
    message:
        "What leaving things out saves, and that it costs no accuracy"
    shell:
        "{params.blas} python -m numerics left-out {input.scenes:q} --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule resolved_strip:
    input:
        config=ancient(CONFIG_FILE),
    output:
        table="<results>/numerics/resolved_strip.csv",
        limits="<results>/numerics/resolved_strip_limits.csv",
    log:
        "<logs>/numerics/resolved_strip.log",
    benchmark:
        "<benchmarks>/numerics/resolved_strip.tsv"
    conda:
        "../../envs/numerics.yaml"
    resources:
        mem_mb=1000,
    params:
        code=CODE["numerics"],
        study=sections("numerics"),
        blas=ONE_BLAS_THREAD,
    message:
        "The film equations on a strip beside one resolved across the gap"
    shell:
        "{params.blas} python -m numerics resolved-strip --config {input.config:q} "
        "--output {output.table:q} --limits {output.limits:q} >{log:q} 2>&1"


rule roofline:
    input:
        config=ancient(CONFIG_FILE),
    output:
        "<results>/numerics/roofline.csv",
    log:
        "<logs>/numerics/roofline.log",
    benchmark:
        "<benchmarks>/numerics/roofline.tsv"
    conda:
        "../../envs/numerics.yaml"
    threads: ALONE
    resources:
        mem_mb=2000,
    params:
        code=CODE["numerics"],
        study=sections("solver"),
    message:
        "The solver's kernels beside the limits of the device"
    shell:
        "python -m numerics roofline --config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule cost:
    input:
        config=ancient(CONFIG_FILE),
    output:
        "<results>/numerics/cost.csv",
    log:
        "<logs>/numerics/cost.log",
    benchmark:
        "<benchmarks>/numerics/cost.tsv"
    conda:
        "../../envs/numerics.yaml"
    threads: ALONE
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        code=CODE["numerics"],
        study=sections("solver", "numerics"),
        blas=ONE_BLAS_THREAD,
    message:
        "Run time and memory against the size of the problem"
    shell:
        "{params.blas} python -m numerics cost --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule conditioning:
    input:
        config=ancient(CONFIG_FILE),
        screen="<results>/simulations/screen/forces.csv",
        design="<results>/simulations/two_factor_design/forces.csv",
        fit="<results>/fits/screen.json",
        searches="<results>/designs/two_factor_searches.csv",
    output:
        "<results>/numerics/conditioning.csv",
    log:
        "<logs>/numerics/conditioning.log",
    conda:
        "../../envs/fit.yaml"
    resources:
        runtime=30,
    params:
        code=CODE["numerics"],
        study=sections("design", "fit", "numerics", "screen"),
        blas=ONE_BLAS_THREAD,
    message:
        "How force errors move the fit and the design"
    shell:
        "{params.blas} python -m numerics conditioning {input.screen:q} {input.design:q} "
        "{input.fit:q} {input.searches:q} --config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule paper_signature:
    input:
        config=ancient(CONFIG_FILE),
        screen="<results>/simulations/screen/forces.csv",
        design="<results>/simulations/two_factor_design/forces.csv",
        extrapolation="<results>/simulations/extrapolation/forces.csv",
    output:
        table="<results>/numerics/paper_signature.csv",
        points="<results>/numerics/paper_signature_points.csv",
    log:
        "<logs>/numerics/paper_signature.log",
    conda:
        "../../envs/numerics.yaml"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=CODE["figures"],
        study=sections("numerics", *FILM),
        blas=ONE_BLAS_THREAD,
    message:
        "Which numerical shortcuts would give the errors that the paper reports"
    shell:
        "{params.blas} python -m paper paper-signature {input.screen:q} {input.design:q} "
        "{input.extrapolation:q} --config {input.config:q} --output {output.table:q} "
        "--points {output.points:q} >{log:q} 2>&1"


rule numerics:
    input:
        expand(
            "<results>/{place}.{format}",
            place=[place for place in STAGES if place.startswith("numerics/")],
            format=["csv", "png", "svg"],
        ),
        "<results>/numerics/roofline.csv",
        "<results>/numerics/equal_error.csv",
    message:
        "Accuracy, run time and stability of the solver are known"

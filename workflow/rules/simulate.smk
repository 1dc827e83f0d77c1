# From a plan to its forces: plan → chunks → forces. As CSV, or for a sweep's many rows as Parquet.

DESIGN_OF_PLAN = {
    "two_factor_design": "<results>/designs/two_factor.csv",
    "four_factor": "<results>/designs/two_factor.csv",
    "four_factor_design": "<results>/designs/four_factor.csv",
    "four_factor_design_distinct": "<results>/designs/four_factor_distinct.csv",
}
# What the points of a plan depend on besides its design; the extrapolation has a rule of its own.
SECTIONS_OF_PLAN = {
    "screen": ["screen"],
    "error_map": ["error_map"],
    "four_factor_control": ["four_factor_control", "screen", "positions", *SHAPES],
    "sweep": ["sweep", "screen", "positions", *SHAPES],
    "validation_two_factor": ["validation", "screen", "positions", *FILM],
    "validation_four_factor": ["validation", "screen", "positions", *FILM],
    "two_factor_design": [],
    "four_factor": ["positions", *SHAPES],
    "four_factor_design": [],
    "four_factor_design_distinct": [],
}


rule plan:
    input:
        profile=SMOOTHED,
        design=lambda wildcards: DESIGN_OF_PLAN.get(wildcards.plan, []),
    output:
        "<results>/simulations/{plan}/scenes.csv",
    log:
        "<logs>/plan/{plan}.log",
    wildcard_constraints:
        plan="|".join(SECTIONS_OF_PLAN),
    localrule: True
    params:
        code=CODE["solver"],
        study=lambda wildcards: sections(*SECTIONS_OF_PLAN[wildcards.plan]),
    message:
        "Points to simulate: {wildcards.plan}"
    script:
        "../scripts/plan.py"


rule plan_extrapolation:
    input:
        fits=["<results>/fits/screen.json", "<results>/fits/two_factor_design.json"],
    output:
        "<results>/simulations/extrapolation/scenes.csv",
    log:
        "<logs>/plan/extrapolation.log",
    localrule: True
    params:
        code=CODE["models"],
        study=sections("extrapolation"),
    message:
        "Points to simulate: where the fitted models expect the wanted force"
    script:
        "../scripts/plan_extrapolation.py"


# Compiled kernels go to the caches, so that the chunks, which start side by side, find them there.
# On another node the first chunk to start compiles, and those beside it wait.
rule compile_kernels:
    input:
        config=ancient(CONFIG_FILE),
        profile=SMOOTHED,
    output:
        "<results>/simulations/device.json",
    log:
        "<logs>/compile_kernels.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "Compile the kernels"
    shell:
        "python -m squeezefilm warm --config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule simulate:
    input:
        config=ancient(CONFIG_FILE),
        scenes="<results>/simulations/{plan}/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        forces="<results>/simulations/{plan}/chunks/{chunk}-of-{chunks}.csv",
        timings="<results>/simulations/{plan}/chunks/{chunk}-of-{chunks}.timings.csv",
    log:
        "<logs>/simulate/{plan}/{chunk}-of-{chunks}.log",
    benchmark:
        "<benchmarks>/simulate/{plan}/{chunk}-of-{chunks}.tsv"
    conda:
        "../../envs/simulate.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: 2000 * attempt,
        runtime=lambda wildcards, attempt: 30 * attempt,
    params:
        code=CODE["solver"],
        study=sections("solver", "outputs", *FILM),
    message:
        "Simulate {wildcards.plan}, part {wildcards.chunk} of {wildcards.chunks}"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
        "python -m squeezefilm simulate {input.scenes:q} "
        "--config {input.config:q} --chunk {wildcards.chunk}/{wildcards.chunks} --keep-going "
        "--output {output.forces:q} --timings {output.timings:q} >{log:q} 2>&1"


rule gather:
    input:
        scenes="<results>/simulations/{plan}/scenes.csv",
        forces=lambda wildcards: chunk_files(wildcards.plan, ".csv"),
        timings=lambda wildcards: chunk_files(wildcards.plan, ".timings.csv"),
    output:
        forces="<results>/simulations/{plan}/forces.csv",
        timings="<results>/simulations/{plan}/timings.csv",
    log:
        "<logs>/gather/{plan}.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["solver"],
        # A scene of a validation sample without a force counts as infinitely wrong.
        keep=lambda wildcards: "--keep-failed " * wildcards.plan.startswith("validation_"),
    message:
        "Forces of {wildcards.plan}: every point solved?"
    shell:
        "python -m squeezefilm gather {input.scenes:q} {input.forces:q} --timings {input.timings:q} {params.keep}"
        "--output {output.forces:q} --timings-output {output.timings:q} >{log:q} 2>&1"


use rule plan as plan_parquet with:
    output:
        "<results>/simulations/{plan}/scenes.parquet",
    log:
        "<logs>/plan/{plan}.parquet.log",
    localrule: True


use rule simulate as simulate_parquet with:
    input:
        config=ancient(CONFIG_FILE),
        scenes="<results>/simulations/{plan}/scenes.parquet",
        kernels="<results>/simulations/device.json",
    output:
        forces="<results>/simulations/{plan}/chunks/{chunk}-of-{chunks}.parquet",
        timings="<results>/simulations/{plan}/chunks/{chunk}-of-{chunks}.timings.parquet",
    log:
        "<logs>/simulate/{plan}/{chunk}-of-{chunks}.parquet.log",
    benchmark:
        "<benchmarks>/simulate/{plan}/{chunk}-of-{chunks}.parquet.tsv"


use rule gather as gather_parquet with:
    input:
        scenes="<results>/simulations/{plan}/scenes.parquet",
        forces=lambda wildcards: chunk_files(wildcards.plan, ".parquet"),
        timings=lambda wildcards: chunk_files(wildcards.plan, ".timings.parquet"),
    output:
        forces="<results>/simulations/{plan}/forces.parquet",
        timings="<results>/simulations/{plan}/timings.parquet",
    log:
        "<logs>/gather/{plan}.parquet.log",
    localrule: True


rule sweep:
    input:
        "<results>/simulations/sweep/forces.parquet",
    message:
        "Every scene of the sweep has its force"


rule plan_budget:
    input:
        config=ancient(CONFIG_FILE),
        scenes="<results>/simulations/{plan}/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        "<results>/simulations/{plan}/budget.csv",
    log:
        "<logs>/budget/{plan}.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "What the film equation leaves out of the forces of {wildcards.plan}"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
        "python -m squeezefilm budget {input.scenes:q} --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule plan_response:
    input:
        config=ancient(CONFIG_FILE),
        scenes="<results>/simulations/{plan}/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        response="<results>/simulations/{plan}/response.csv",
        gains="<results>/simulations/{plan}/gains.csv",
    log:
        "<logs>/response/{plan}.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "How the forces of {wildcards.plan} follow a changing amplitude"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
        "python -m squeezefilm response {input.scenes:q} --config {input.config:q} "
        "--frequencies 3Hz,10Hz,30Hz,60Hz,100Hz,150Hz,200Hz,300Hz,500Hz,700Hz,1kHz,2kHz,4kHz "
        "--output {output.response:q} --gains {output.gains:q} >{log:q} 2>&1"


rule plan_levitation:
    input:
        config=ancient(CONFIG_FILE),
        forces="<results>/simulations/{plan}/forces.csv",
        kernels="<results>/simulations/device.json",
    output:
        "<results>/simulations/{plan}/levitation.csv",
    log:
        "<logs>/levitation/{plan}.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "The gaps that carry loads as in {wildcards.plan}"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
        "python -m squeezefilm levitate --like {input.forces:q} --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule explain:
    input:
        config=ancient(CONFIG_FILE),
        scenes="<results>/simulations/{plan}/scenes.csv",
    output:
        "<results>/simulations/{plan}/explained.csv",
    log:
        "<logs>/explain/{plan}.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["solver"],
        study=sections("solver", "outputs", *FILM),
    message:
        "What {wildcards.plan} needs, and what is left out"
    shell:
        "python -m squeezefilm explain {input.scenes:q} --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule film_tables:
    input:
        rules.compile_kernels.output,
        "<results>/simulations/extrapolation/film.csv",
        expand(
            "<results>/simulations/screen/{table}.csv",
            table=["budget", "gains", "levitation", "response"],
        ),
        expand("<results>/simulations/{plan}/budget.csv", plan=["four_factor", "extrapolation"]),
    message:
        "What the films of the plans do besides is known"


rule provenance:
    input:
        config=ancient(CONFIG_FILE),
        device="<results>/simulations/device.json",
    output:
        "<results>/provenance.json",
    log:
        "<logs>/provenance.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["figures"],
        study=sections(*CONFIG),
    message:
        "What makes these results: code, packages, device, study"
    shell:
        "python -m squeezefilm provenance {input.device:q} --config {input.config:q} "
        "--output {output:q} >{log:q} 2>&1"


rule explained:
    input:
        expand("<results>/simulations/{plan}/explained.csv", plan=["screen", "four_factor"]),
    message:
        "What the scenes of the two plans need is written down"

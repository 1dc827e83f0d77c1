# From a plan to its forces. As CSV, or for a sweep's many rows as Parquet.

# Plans that are simulated by several jobs; all others by one that makes the plan too.
DIVIDED = [plan for plan in SECTIONS_OF_PLAN if CHUNKS.get(plan, 1) > 1]


# Compiled kernels go to the caches, so that jobs that start side by side find them there. On
# another node the first job to start compiles, and those beside it wait.
rule compile_kernels:
    input:
        profile=SMOOTHED,
    output:
        "<results>/simulations/device.json",
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "Compile the kernels"
    script:
        "../scripts/compile_kernels.py"


rule simulate_plan:
    input:
        sources=lambda wildcards: SOURCES_OF_PLAN.get(wildcards.plan, []),
        kernels=rules.compile_kernels.output,
    output:
        scenes=f"{PLAN}/scenes.{{suffix}}",
        forces=f"{PLAN}/forces.{{suffix}}",
        timings=f"{PLAN}/timings.{{suffix}}",
    log:
        "<logs>/simulate/{plan}.{suffix}.log",
    benchmark:
        "<benchmarks>/simulate/{plan}.{suffix}.tsv"
    wildcard_constraints:
        plan="|".join(plan for plan in SECTIONS_OF_PLAN if plan not in DIVIDED),
    resources:
        mem_mb=lambda wildcards, attempt: 2000 * attempt,
        runtime=lambda wildcards, attempt: 30 * attempt,
    params:
        code=code_of_plan,
        study=lambda wildcards: sections(
            "solver", "outputs", *FILM, *SECTIONS_OF_PLAN[wildcards.plan]
        ),
        keep_failed=keep_failed,
    message:
        "Simulate {wildcards.plan}"
    script:
        "../scripts/simulate_plan.py"


rule plan:
    input:
        profile=SMOOTHED,
        sources=lambda wildcards: SOURCES_OF_PLAN.get(wildcards.plan, []),
    output:
        f"{PLAN}/scenes.{{suffix}}",
    wildcard_constraints:
        plan="|".join(DIVIDED) or "(?!)",
    params:
        code=code_of_plan,
        study=lambda wildcards: sections(*FILM, *SECTIONS_OF_PLAN[wildcards.plan]),
    message:
        "Points to simulate: {wildcards.plan}"
    script:
        "../scripts/plan.py"


rule simulate:
    input:
        scenes=f"{PLAN}/scenes.{{suffix}}",
        kernels=rules.compile_kernels.output,
    output:
        forces=f"{PLAN}/chunks/{{chunk}}-of-{{chunks}}.{{suffix}}",
        timings=f"{PLAN}/chunks/{{chunk}}-of-{{chunks}}.timings.{{suffix}}",
    log:
        "<logs>/simulate/{plan}/{chunk}-of-{chunks}.{suffix}.log",
    benchmark:
        "<benchmarks>/simulate/{plan}/{chunk}-of-{chunks}.{suffix}.tsv"
    resources:
        mem_mb=lambda wildcards, attempt: 2000 * attempt,
        runtime=lambda wildcards, attempt: 30 * attempt,
    params:
        code=CODE["solver"],
        study=sections("solver", "outputs", *FILM),
    message:
        "Simulate {wildcards.plan}, part {wildcards.chunk} of {wildcards.chunks}"
    script:
        "../scripts/simulate.py"


rule merge:
    input:
        scenes=f"{PLAN}/scenes.{{suffix}}",
        forces=lambda wildcards: chunk_files(wildcards, ""),
        timings=lambda wildcards: chunk_files(wildcards, ".timings"),
    output:
        forces=f"{PLAN}/forces.{{suffix}}",
        timings=f"{PLAN}/timings.{{suffix}}",
    wildcard_constraints:
        plan="|".join(DIVIDED) or "(?!)",
    params:
        code=CODE["solver"],
        keep_failed=keep_failed,
    message:
        "Forces of {wildcards.plan}: every point solved?"
    script:
        "../scripts/merge.py"


rule sweep:
    input:
        expand("<results>/simulations/sweep/{table}.parquet", table=["scenes", "forces", "timings"]),
    message:
        "Every scene of the sweep has its force"


rule plan_budget:
    input:
        scenes=f"{PLAN}/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        f"{PLAN}/budget.csv",
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "What the film equation leaves out of the forces of {wildcards.plan}"
    script:
        "../scripts/budget.py"


rule plan_response:
    input:
        scenes=f"{PLAN}/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        response=f"{PLAN}/response.csv",
        gains=f"{PLAN}/gains.csv",
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "How the forces of {wildcards.plan} follow a changing amplitude"
    script:
        "../scripts/response.py"


rule plan_levitation:
    input:
        forces=f"{PLAN}/forces.csv",
        kernels="<results>/simulations/device.json",
    output:
        f"{PLAN}/levitation.csv",
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM),
    message:
        "The gaps that carry loads as in {wildcards.plan}"
    script:
        "../scripts/levitation.py"


rule film_tables:
    input:
        rules.compile_kernels.output,
        "<results>/simulations/extrapolation/film.csv",
        expand(
            "<results>/simulations/screen/{table}.csv",
            table=["budget", "gains", "levitation", "response"],
        ),
        expand(f"{PLAN}/budget.csv", plan=["four_factor", "extrapolation"]),
    message:
        "What the films of the plans do besides is known"


rule provenance:
    input:
        rules.compile_kernels.output,
    output:
        "<results>/provenance.json",
    params:
        study=sections(*CONFIG),
    message:
        "What makes these results: code, packages, device, study"
    script:
        "../scripts/provenance.py"

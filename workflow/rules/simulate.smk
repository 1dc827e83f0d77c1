# From a plan to its forces. As CSV, or for a sweep's many rows as Parquet.

# Tables of the films of some plans, beside their forces; of positions, at the largest hv/h0.
FILM_TABLES = {
    "screen": ["error_budget", "gains", "levitation", "response"],
    "four_factor": ["error_budget"],
    "extrapolation": ["error_budget", "film"],
}
# Plans that are simulated by several jobs; all others by one that makes the plan too.
DIVIDED = [plan for plan in PLANS if CHUNKS.get(plan, 1) > 1]


# Compiled kernels go to the caches, so that jobs that start side by side find them there. On
# another node the first job to start compiles, and those beside it wait.
rule compile_kernels:
    input:
        profile=SMOOTHED,
    output:
        "<results>/simulations/device.json",
    log:
        "<logs>/compile_kernels.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("solver", "compile_kernels"),
        study=sections("solver", *FILM),
    message:
        "Compile the kernels"
    script:
        "../scripts/compile_kernels.py"


rule simulate_plan:
    input:
        sources=sources_of_plan,
        kernels=rules.compile_kernels.output,
    output:
        scenes=f"{PLAN}/scenes.{{suffix}}",
        forces=f"{PLAN}/forces.{{suffix}}",
        timings=f"{PLAN}/timings.{{suffix}}",
    log:
        "<logs>/simulate_plan/{plan}/{suffix}.log",
    benchmark:
        "<benchmarks>/simulate_plan/{plan}/{suffix}.tsv"
    wildcard_constraints:
        plan="|".join(plan for plan in PLANS if plan not in DIVIDED),
    priority: 1
    conda:
        "../../envs/workflow.yaml"
    resources:
        mem_mb=growing(2000),
        runtime=growing(30),
    params:
        code=lambda wildcards: code_of(stage_of_plan(wildcards.plan), "simulate"),
        study=lambda wildcards: sections("solver", "outputs", *FILM, *PLANS[wildcards.plan][0]),
        # A scene of a validation sample that has no force counts as infinitely wrong.
        keep_failed=lambda wildcards: wildcards.plan.startswith("validation_"),
    message:
        "Simulate {wildcards.plan}"
    script:
        "../scripts/simulate.py"


rule plan:
    input:
        profile=SMOOTHED,
        sources=sources_of_plan,
    output:
        f"{PLAN}/scenes.{{suffix}}",
    log:
        "<logs>/plan/{plan}/{suffix}.log",
    wildcard_constraints:
        plan="|".join(DIVIDED) or "(?!)",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=lambda wildcards: code_of(stage_of_plan(wildcards.plan), "plan"),
        study=lambda wildcards: sections(*FILM, *PLANS[wildcards.plan][0]),
    message:
        "Points to simulate: {wildcards.plan}"
    script:
        "../scripts/plan.py"


use rule simulate_plan as simulate with:
    input:
        scenes=f"{PLAN}/scenes.{{suffix}}",
        kernels=rules.compile_kernels.output,
    output:
        forces=f"{PLAN}/chunks/{{chunk}}-of-{{chunks}}.{{suffix}}",
        timings=f"{PLAN}/chunks/{{chunk}}-of-{{chunks}}.timings.{{suffix}}",
    log:
        "<logs>/simulate/{chunk}/{chunks}/{plan}/{suffix}.log",
    benchmark:
        "<benchmarks>/simulate/{chunk}/{chunks}/{plan}/{suffix}.tsv"
    wildcard_constraints:
        plan="|".join(PLANS),
    params:
        code=code_of("solver", "simulate"),
        study=sections("solver", "outputs", *FILM),
    message:
        "Simulate {wildcards.plan}, part {wildcards.chunk} of {wildcards.chunks}"


rule merge:
    input:
        scenes=f"{PLAN}/scenes.{{suffix}}",
        forces=lambda wildcards: chunk_files(wildcards, ""),
        timings=lambda wildcards: chunk_files(wildcards, ".timings"),
    output:
        forces=f"{PLAN}/forces.{{suffix}}",
        timings=f"{PLAN}/timings.{{suffix}}",
    log:
        "<logs>/merge/{plan}/{suffix}.log",
    wildcard_constraints:
        plan="|".join(DIVIDED) or "(?!)",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("solver", "merge"),
        keep_failed=lambda wildcards: wildcards.plan.startswith("validation_"),
    message:
        "Forces of {wildcards.plan}: every point solved?"
    script:
        "../scripts/merge.py"


rule sweep:
    input:
        expand("<results>/simulations/sweep/{table}.parquet", table=["scenes", "forces", "timings"]),
    message:
        "Every scene of the sweep has its force"


for plan, tables in FILM_TABLES.items():

    rule:
        name:
            f"films_{plan}"
        input:
            scenes=f"<results>/simulations/{plan}/scenes.csv",
            forces=f"<results>/simulations/{plan}/forces.csv",
            kernels=rules.compile_kernels.output,
        output:
            expand(f"<results>/simulations/{plan}/{{table}}.csv", table=tables),
        log:
            f"<logs>/films_{plan}.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("figures" if "film" in tables else "solver", "film_tables"),
            study=sections("solver", *FILM),
            largest_amplitude_ratio=plan == "four_factor",
        message:
            f"Tables of the films of {plan}: {', '.join(tables)}"
        script:
            "../scripts/film_tables.py"

# Candidates for the force model, the paper's, physics and your own, side by side: `snakemake models`.

MODEL_SPACES = {"two_factor": "finger centred", "four_factor": "finger anywhere"}
# The points that candidates are fitted to.
FITTED_PLAN = {"two_factor": "screen", "four_factor": "four_factor"}

# What the recommended model is judged by; the first has the positions.
RECOMMENDED_BY = ["four_factor", *(f"validation_{space}" for space in MODEL_SPACES)]


wildcard_constraints:
    space="|".join(MODEL_SPACES),
    model="[a-z][a-z0-9_]*",


rule limits:
    input:
        scenes="<results>/simulations/{plan}/scenes.csv",
    output:
        "<results>/simulations/{plan}/limits.csv",
    log:
        "<logs>/limits/{plan}.log",
    params:
        code=CODE["models"],
        study=sections(*FILM),
    message:
        "What physics says of {wildcards.plan} with nothing fitted"
    script:
        "../scripts/limits.py"


rule limit_table:
    input:
        profile=SMOOTHED,
    output:
        "<results>/models/limit_table.json",
    log:
        "<logs>/models/limit_table.log",
    params:
        code=CODE["models"],
        study=sections("screen", "positions", *FILM),
    message:
        "What physics says all over the space, for models that use it"
    script:
        "../scripts/limit_table.py"


rule fit_candidate:
    input:
        forces=lambda wildcards: f"<results>/simulations/{FITTED_PLAN[wildcards.space]}/forces.csv",
        limits=lambda wildcards: f"<results>/simulations/{FITTED_PLAN[wildcards.space]}/limits.csv",
        limit_table="<results>/models/limit_table.json",
        sample="<results>/simulations/validation_{space}/forces.csv",
        sample_limits="<results>/simulations/validation_{space}/limits.csv",
        scan=SCAN_SUMMARY,
    output:
        "<results>/models/{space}/{model}.json",
    log:
        "<logs>/models/{space}/{model}.log",
    params:
        code=CODE["models"],
        study=sections("fit", "models", "screen", "positions", *SHAPES),
    message:
        "Fit the candidate {wildcards.model} to {wildcards.space} points"
    script:
        "../scripts/fit_candidate.py"


rule compare:
    input:
        config=ancient(CONFIG_FILE),
        fits=lambda wildcards: [
            f"<results>/models/{wildcards.space}/{model}.json"
            for model in CONFIG["comparison"][wildcards.space]
        ],
        forces="<results>/simulations/validation_{space}/forces.csv",
        limits="<results>/simulations/validation_{space}/limits.csv",
    output:
        table="<results>/models/{space}.csv",
        text="<results>/models/{space}.md",
        errors="<results>/models/{space}_errors.csv",
    log:
        "<logs>/models/compare_{space}.log",
    params:
        code=CODE["figures"],
        study=sections("comparison"),
    message:
        "Candidates side by side on {wildcards.space} points"
    shell:
        "python -m reporting compare {wildcards.space} {input.fits:q} --config {input.config:q} "
        "--forces {input.forces:q} --limits {input.limits:q} --output {output.table:q} --report {output.text:q} "
        "--errors {output.errors:q} >{log:q} 2>&1"


rule recommend:
    input:
        config=ancient(CONFIG_FILE),
        tables=expand("<results>/models/{space}.csv", space=MODEL_SPACES),
        forces=expand("<results>/simulations/{plan}/forces.csv", plan=RECOMMENDED_BY),
    output:
        "<results>/models/recommended.csv",
    log:
        "<logs>/models/recommend.log",
    params:
        code=CODE["figures"],
        study=sections("extrapolation"),
        results=lambda wildcards, output: str(Path(output[0]).parent.parent),
        forces=lambda wildcards, input: named(input.forces, names=RECOMMENDED_BY),
    message:
        "The best model, and the amplitude for the wanted force at each position"
    shell:
        "python -m reporting recommend {params.results:q} --config {input.config:q} "
        "--forces {params.forces} --output {output:q} >{log:q} 2>&1"


rule models_page:
    input:
        config=ancient(CONFIG_FILE),
        tables=expand("<results>/models/{space}.md", space=MODEL_SPACES),
    output:
        [
            report(
                f"<results>/models/{space}.html",
                category="6 Models",
                labels={"shows": f"table, {shows}"},
                caption="../report/models.rst",
            )
            for space, shows in MODEL_SPACES.items()
        ],
    log:
        "<logs>/models/pages.log",
    params:
        code=CODE["figures"],
        study=sections("screen", *FILM),
    message:
        "The comparison of models as pages"
    shell:
        "python -m reporting pages {input.tables:q} --config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule models:
    input:
        rules.models_page.output,
        rules.limit_table.output,
        rules.recommend.output,
        [limit_tables(space) for space in MODEL_SPACES],
        [
            f"<results>/models/{space}/{model}.json"
            for space in MODEL_SPACES
            for model in CONFIG["comparison"][space]
        ],
        expand("<results>/models/{space}.{format}", space=MODEL_SPACES, format=["csv", "md"]),
        expand(
            "<results>/models/{space}_errors.{format}",
            space=MODEL_SPACES,
            format=["csv", "png", "svg"],
        ),
    message:
        "Candidates for the force model are compared"

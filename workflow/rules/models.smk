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
    params:
        code=CODE["models"],
        study=sections("fit", "models", "screen", "positions", *SHAPES),
    message:
        "Fit the candidate {wildcards.model} to {wildcards.space} points"
    script:
        "../scripts/fit_candidate.py"


rule compare:
    input:
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
        page=listed("models/{space}.html", "6 Models", caption="models", shows="table, {space}"),
    params:
        study=sections("comparison", "screen", *FILM),
    message:
        "Candidates side by side on {wildcards.space} points"
    script:
        "../scripts/compare_models.py"


rule recommend:
    input:
        expand("<results>/models/{space}.csv", space=MODEL_SPACES),
        expand("<results>/simulations/{plan}/forces.csv", plan=RECOMMENDED_BY),
    output:
        "<results>/models/recommended.csv",
    params:
        study=sections("extrapolation"),
    message:
        "The best model, and the amplitude for the wanted force at each position"
    script:
        "../scripts/recommend.py"


rule models:
    input:
        rules.limit_table.output,
        rules.recommend.output,
        [limit_tables(space) for space in MODEL_SPACES],
        [
            f"<results>/models/{space}/{model}.json"
            for space in MODEL_SPACES
            for model in CONFIG["comparison"][space]
        ],
        expand(
            "<results>/models/{space}.{format}", space=MODEL_SPACES, format=["csv", "md", "html"]
        ),
        expand(
            "<results>/models/{space}_errors.{format}",
            space=MODEL_SPACES,
            format=["csv", "png", "svg"],
        ),
    message:
        "Candidates for the force model are compared"

# Candidates for the force model, the paper's, physics and your own, side by side: `snakemake models`.

# What the recommended model is judged by; the first has the positions.
RECOMMENDED_BY = ["four_factor", *expand("validation_{space}", space=FITS)]


wildcard_constraints:
    space="|".join(FITS),
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
        forces=lambda wildcards: f"<results>/simulations/{FITS[wildcards.space][0]}/forces.csv",
        limits=lambda wildcards: f"<results>/simulations/{FITS[wildcards.space][0]}/limits.csv",
        limit_table="<results>/models/limit_table.json",
        sample="<results>/simulations/validation_{space}/forces.csv",
        sample_limits="<results>/simulations/validation_{space}/limits.csv",
        scan=SCAN_SUMMARY,
    output:
        fit="<results>/models/{space}/{model}.json",
    params:
        code=CODE["models"],
        study=sections("fit", "models", "screen", "positions", *SHAPES),
        model="{model}",
        seeds=1,
    message:
        "Fit the candidate {wildcards.model} to {wildcards.space} points"
    script:
        "../scripts/fit.py"


rule compare:
    input:
        fits=lambda wildcards: candidate_files(wildcards.space),
        forces="<results>/simulations/validation_{space}/forces.csv",
        limits="<results>/simulations/validation_{space}/limits.csv",
    output:
        table="<results>/models/{space}.csv",
        markdown="<results>/models/{space}.md",
        errors="<results>/models/{space}_errors.csv",
        page=listed("models/{space}.html", "6 Models", caption="models", shows="table, {space}"),
    params:
        study=sections("comparison", "screen", *FILM),
        page="models",
    message:
        "Candidates side by side on {wildcards.space} points"
    script:
        "../scripts/page.py"


rule recommend:
    input:
        expand("<results>/models/{space}.csv", space=FITS),
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
        [limit_tables(space) for space in FITS],
        [candidate_files(space) for space in FITS],
        expand(
            "<results>/models/{space}{end}",
            space=FITS,
            end=[".csv", ".md", ".html", "_errors.csv", "_errors.png", "_errors.svg"],
        ),
    message:
        "Candidates for the force model are compared"

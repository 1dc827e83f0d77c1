# Candidates for the force model, the paper's, physics and your own, side by side: `snakemake models`.

# Plans that validate the recommended model; the first has the positions.
RECOMMENDED_BY = ["four_factor", *expand("validation_{space}", space=FITS)]


wildcard_constraints:
    space="|".join(FITS),
    model="[a-z][a-z0-9_]*",


rule limit_table:
    input:
        profile=SMOOTHED,
    output:
        "<results>/models/limit_table.json",
    log:
        "<logs>/limit_table.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("models", "limit_table"),
        study=sections("screen", "positions", *FILM),
    message:
        "Asymptotic forces over the space, for models that use them"
    script:
        "../scripts/limit_table.py"


# All of a space and the asymptotic forces at its points: a process takes longer to start than to fit.
for space, (plan, *_) in FITS.items():

    rule:
        name:
            f"fit_candidates_{space}"
        input:
            forces=f"<results>/simulations/{plan}/forces.csv",
            sample=f"<results>/simulations/validation_{space}/forces.csv",
            limit_table=rules.limit_table.output[0],
            scan=SCAN_SUMMARY,
        output:
            fits=candidate_files(space),
            limits=limit_tables(space),
        log:
            f"<logs>/fit_candidates_{space}.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("models", "fit"),
            study=sections("fit", "models", "screen", "positions", *FILM),
            models=candidates(space),
            seeds=1,
        message:
            f"Fit candidates to {space} points"
        script:
            "../scripts/fit.py"


rule compare:
    input:
        fits=lambda wildcards: candidate_files(wildcards.space),
        own=lambda wildcards: f"<results>/fits/{FITS[wildcards.space][0]}.json",
        points=lambda wildcards: f"<results>/simulations/{FITS[wildcards.space][0]}/forces.csv",
        forces="<results>/simulations/validation_{space}/forces.csv",
        limits=lambda wildcards: limit_tables(wildcards.space),
    output:
        table="<results>/models/{space}.csv",
        errors="<results>/models/{space}_errors.csv",
        page=listed(
            "models/{space}.html", CATEGORY["Models"], caption="models", shows="table, {space}"
        ),
    log:
        "<logs>/compare/{space}.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "page"),
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
        # The model that is recommended is one of these.
        [candidate_files(space) for space in FITS],
        [f"<results>/fits/{plan}.json" for plan, *_ in FITS.values()],
    output:
        "<results>/models/recommended.csv",
    log:
        "<logs>/recommend.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "recommend"),
        study=sections("extrapolation"),
    message:
        "The best model, and the amplitude for the target force at each position"
    script:
        "../scripts/recommend.py"


rule models:
    input:
        rules.limit_table.output,
        rules.recommend.output,
        [limit_tables(space) for space in FITS],
        [candidate_files(space) for space in FITS],
        expand(rules.compare.output, space=FITS),
        [pictures(f"models/{space}_errors") for space in FITS],
    message:
        "Compared in results/{STUDY}/models; `squeezefilm recommend results/{STUDY}` names the best"

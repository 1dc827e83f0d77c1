# From forces to the parameters of an empirical model. A fit bears the name of its plan.

MODEL_OF_FIT = {
    "screen": "two-factor",
    "two_factor_design": "two-factor",
    "four_factor": "four-factor",
    "four_factor_design": "four-factor",
    "four_factor_design_distinct": "four-factor",
}
SPACE_OF_FIT = {fit: model.replace("-", "_") for fit, model in MODEL_OF_FIT.items()}


rule fit:
    input:
        forces="<results>/simulations/{fit}/forces.csv",
        sample=lambda wildcards: (
            f"<results>/simulations/validation_{SPACE_OF_FIT[wildcards.fit]}/forces.csv"
        ),
        scan=SCAN_SUMMARY,
    output:
        fit="<results>/fits/{fit}.json",
        runs="<results>/fits/{fit}_runs.csv",
    log:
        "<logs>/fit/{fit}.log",
    threads: cores_for(sum(CONFIG["fit"]["seeds"].values()))
    params:
        code=CODE["models"],
        study=sections("fit", "models", "screen", "positions", *SHAPES),
        model=lambda wildcards: MODEL_OF_FIT[wildcards.fit],
    message:
        "Fit the {params.model} model to {wildcards.fit}"
    script:
        "../scripts/fit.py"

# From forces to the parameters of an empirical model. A fit bears the name of its plan.


rule fit:
    input:
        forces="<results>/simulations/{fit}/forces.csv",
        sample=lambda wildcards: (
            f"<results>/simulations/validation_{MODEL_OF_FIT[wildcards.fit]}/forces.csv"
        ),
        scan=SCAN_SUMMARY,
    output:
        fits=["<results>/fits/{fit}.json"],
        runs="<results>/fits/{fit}_runs.csv",
    log:
        "<logs>/fit/{fit}.log",
    # All that is designed and judged waits for it.
    priority: 2
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    threads: cores_for(CONFIG.fit.seeds.two_factor + CONFIG.fit.seeds.four_factor)
    params:
        code=code_of("models", "fit"),
        study=sections("fit", "models", "screen", "positions", *SHAPES),
        models=lambda wildcards: [MODEL_OF_FIT[wildcards.fit]],
        seeds=None,
    message:
        "Fit the {params.models} model to {wildcards.fit}"
    script:
        "../scripts/fit.py"

# A page in which the fitted models can be played with.

# The first one is shown first, in a study that recommends no model.
EXPLORER_FITS = ["two_factor_design", "screen", *FITS["four_factor"]]
EXPLORER_PLANS = ["screen", "error_map", "two_factor_design", *FITS["four_factor"]]


rule explorer:
    input:
        expand("<results>/fits/{fit}.json", fit=EXPLORER_FITS),
        candidate_files("four_factor"),
        [] if PAPER else [rules.compare.output.recommended, candidate_files("two_factor")],
        expand("<results>/simulations/{plan}/forces.csv", plan=EXPLORER_PLANS),
        expand(
            "<results>/simulations/screen/{table}.csv", table=["response", "gains", "error_budget"]
        ),
    output:
        "<results>/explorer.html",
    log:
        "<logs>/explorer.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "explorer"),
        study=sections(),
        fits=EXPLORER_FITS,
        candidates=candidates("four_factor"),
        plans=EXPLORER_PLANS,
    message:
        "The explorer: a page to play with the models"
    script:
        "../scripts/explorer.py"

# Pages for `snakemake --report`, which puts them into one file with the figures. Its categories
# stand in the order of their names, hence the numbers.

VALIDATIONS = [pair for space in FITS for pair in validations(space)]
SUMMARY_PLANS = [*FITS["two_factor"], "error_map", "extrapolation", *JUDGED_ON["four_factor"]]
SUMMARY_PLANS += [*FITS["four_factor"][1:], *expand("validation_{space}", space=FITS)]

# The figures with which the summary opens, by what they show.
PICTURES = {
    "vibration": "fig05" if PAPER else "vibration",
    "forces": "forces",
    "fitted_model": "fig08" if PAPER else "fitted_model",
    "design": "fig12" if PAPER else "design",
    "error_map": "error_map",
    **({} if PAPER else {"amplitudes": "amplitudes"}),
}


rule summary:
    input:
        expand("<results>/validation/{pair}.json", pair=VALIDATIONS),
        expand("<results>/simulations/{plan}/forces.csv", plan=SUMMARY_PLANS),
        expand("<results>/fits/{fit}.json", fit=MODEL_OF_FIT),
        "<results>/claims.csv" if PAPER else "<results>/models/recommended.csv",
        "<results>/simulations/device.json",
        "<results>/simulations/screen/error_budget.csv",
        SCAN_SUMMARY,
        "<results>/measurements/summary.json" if MEASURED else [],
        expand("<results>/figures/{name}.png", name=PICTURES.values()),
        profile=SMOOTHED,
    output:
        page=listed(
            "report/summary.html",
            SUMMARY,
            page="1 Summary: what was simulated, how accurate"
            + (", where it differs" if PAPER else ""),
            caption="summary",
        ),
        front="<results>/report/front.rst",
        provenance="<results>/provenance.json",
    log:
        "<logs>/summary.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "page"),
        study=sections(),
        page="summary",
        about={
            "plans": SUMMARY_PLANS,
            "fits": list(MODEL_OF_FIT),
            "pairs": VALIDATIONS,
            "pictures": PICTURES,
        },
        paper=PAPER,
    message:
        "The study on one page, the report's first page, and what made them"
    script:
        "../scripts/page.py"


if PAPER:

    rule uncertainty_table:
        input:
            kernels="<results>/simulations/device.json",
        output:
            csv="<results>/tables/uncertainty.csv",
            page=listed(
                "report/uncertainty.html",
                SUMMARY,
                page="3 Uncertainty: what would explain a difference from the paper",
                caption="uncertainty",
            ),
        log:
            "<logs>/uncertainty_table.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("figures", "page"),
            study=sections("solver", "screen", "extrapolation", *FILM),
            page="uncertainty",
        message:
            "What would explain the differences from the paper"
        script:
            "../scripts/page.py"

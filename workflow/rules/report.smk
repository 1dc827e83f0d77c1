# Pages for `snakemake --report`, which puts them into one file with the figures.
#
# Its categories stand in the order of their names, hence the numbers.

VALIDATIONS = [*VALIDATIONS_TWO_FACTOR, *VALIDATIONS_FOUR_FACTOR]
SUMMARY_PLANS = [
    "screen",
    "two_factor_design",
    "error_map",
    "extrapolation",
    "four_factor",
    *(["four_factor_control"] if PAPER else []),
    "four_factor_design",
    "four_factor_design_distinct",
]

# What says most at one glance.
FRONT_PICTURES = (
    ["overview", "fig08", "error_map"] if PAPER else ["overview", "force_map", "budget"]
)


rule summary:
    input:
        expand("<results>/validation/{pair}.json", pair=VALIDATIONS),
        expand("<results>/simulations/{plan}/forces.csv", plan=SUMMARY_PLANS),
        expand("<results>/fits/{fit}.json", fit=MODEL_OF_FIT),
        "<results>/claims.csv" if PAPER else "<results>/models/recommended.csv",
        "<results>/simulations/device.json",
        "<results>/simulations/screen/budget.csv",
        SCAN_SUMMARY,
        pictures=expand("<results>/figures/{name}.png", name=FRONT_PICTURES),
    output:
        markdown="<results>/summary.md",
        page=listed(
            "report/summary.html",
            SUMMARY,
            page="1 Summary: what was simulated, how accurate"
            + (", where it differs" if PAPER else ""),
            caption="summary",
        ),
        front="<results>/report/front.rst",
    params:
        study=sections(*CONFIG),
        plans=SUMMARY_PLANS,
        fits=list(MODEL_OF_FIT),
        pairs=VALIDATIONS,
        paper=PAPER,
    message:
        "The study on one page, and the report's first page"
    script:
        "../scripts/summary.py"

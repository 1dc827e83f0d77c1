# Pages for `snakemake --report`, which puts them into one file with the figures.
#
# Its categories stand in the order of their names, hence the numbers.

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
        expand(
            "<results>/validation/{pair}.json",
            pair=[*VALIDATIONS_TWO_FACTOR, *VALIDATIONS_FOUR_FACTOR],
        ),
        expand("<results>/simulations/{plan}/forces.csv", plan=SUMMARY_PLANS),
        expand("<results>/fits/{fit}.json", fit=FITS),
        "<results>/claims.csv" if PAPER else [],
        "<results>/simulations/device.json",
        "<results>/simulations/screen/budget.csv",
        "<results>/models/recommended.csv" if not PAPER else [],
        SCAN_SUMMARY,
        config=ancient(CONFIG_FILE),
    output:
        "<results>/summary.md",
    log:
        "<logs>/report/summary.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["figures"],
        study=sections(*CONFIG),
        results=lambda wildcards, output: str(Path(output[0]).parent),
        plans=SUMMARY_PLANS,
        fits=FITS,
        pairs=[*VALIDATIONS_TWO_FACTOR, *VALIDATIONS_FOUR_FACTOR],
    message:
        "The study on one page"
    shell:
        "python -m reporting summary {params.results:q} --config {input.config:q} --forces {params.plans} "
        "--fits {params.fits} --validations {params.pairs} --output {output:q} >{log:q} 2>&1"


rule pages:
    input:
        config=ancient(CONFIG_FILE),
        summary="<results>/summary.md",
    output:
        report(
            "<results>/report/summary.html",
            category="1 Summary and claims" if PAPER else "1 Summary",
            labels={
                "page": "1 Summary: what was simulated, how accurate"
                + (", where it differs" if PAPER else "")
            },
            caption="../report/summary.rst",
        ),
    log:
        "<logs>/report/pages.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["figures"],
        study=sections("screen", *FILM),
        paper=PAPER,
    message:
        "The summary as a page"
    shell:
        "python -m reporting pages {input.summary:q} --config {input.config:q} --output {output:q} >{log:q} 2>&1"


rule front:
    input:
        summary="<results>/summary.md",
        pictures=expand("<results>/figures/{name}.png", name=FRONT_PICTURES),
    output:
        "<results>/report/front.rst",
    log:
        "<logs>/report/front.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["figures"],
        command="paper paper-front" if PAPER else "reporting front",
    message:
        "The report's first page"
    shell:
        "python -m {params.command} {input.summary:q} --pictures {input.pictures:q} "
        "--output {output:q} >{log:q} 2>&1"


rule paper_pages:
    input:
        claims="<results>/claims.md",
        uncertainty="<results>/tables/uncertainty.md",
        tables=expand("<results>/tables/table{number}.md", number=TABLES),
    output:
        claims=report(
            "<results>/report/claims.html",
            category="1 Summary and claims",
            labels={"page": "2 Claims: the paper beside ours, each with a verdict"},
            caption="../report/claims.rst",
        ),
        uncertainty=report(
            "<results>/report/uncertainty.html",
            category="1 Summary and claims",
            labels={"page": "3 Uncertainty: what would explain a difference from the paper"},
            caption="../report/uncertainty.rst",
        ),
        tables=[
            report(
                f"<results>/report/table{number}.html",
                category="2 Tables",
                labels={"table": number, "shows": table.shows},
                caption="../report/table.rst",
            )
            for number, table in TABLES.items()
        ],
    log:
        "<logs>/report/paper_pages.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["figures"],
    message:
        "Claims, uncertainty and tables as pages"
    shell:
        "python -m reporting pages {input.claims:q} {input.uncertainty:q} {input.tables:q} --output {output:q} >{log:q} 2>&1"

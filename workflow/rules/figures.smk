# From results to figures, tables and claims. A figure is drawn from its one table alone.

DEVICE = "<results>/simulations/device.json"
SCREEN = "<results>/simulations/screen/forces.csv"
DESIGN_FORCES = "<results>/simulations/two_factor_design/forces.csv"
DESIGN_ON_SCREEN = "<results>/validation/two_factor_design_on_screen"
TWO_FACTOR_SEARCHES = {
    "plan": "<results>/simulations/screen/scenes.csv",
    "searches": "<results>/designs/two_factor_searches.csv",
    "summary": "<results>/designs/two_factor.json",
}
FIGURE_INPUTS = {
    "fig05": {},
    "fig06": {},
    "fig07": {"plan": "<results>/simulations/screen/scenes.csv"},
    "fig08": {"forces": SCREEN, "fit": "<results>/fits/screen.json", "device": DEVICE},
    "fig09": TWO_FACTOR_SEARCHES,
    "fig10": TWO_FACTOR_SEARCHES,
    "fig11": TWO_FACTOR_SEARCHES,
    "fig12": {
        "plan": "<results>/simulations/screen/scenes.csv",
        "design": "<results>/designs/two_factor.csv",
    },
    "fig13": {
        "design_forces": DESIGN_FORCES,
        "fit": "<results>/fits/two_factor_design.json",
        "control_forces": SCREEN,
        "validation": f"{DESIGN_ON_SCREEN}.json",
        "device": DEVICE,
    },
    "fig14": {
        "fit": "<results>/fits/two_factor_design.json",
        "forces": SCREEN,
        "errors": f"{DESIGN_ON_SCREEN}.csv",
        "validation": f"{DESIGN_ON_SCREEN}.json",
        "device": DEVICE,
    },
    "fig15": {"plan": "<results>/simulations/four_factor/scenes.csv"},
    "fig16": {
        "plan": "<results>/simulations/four_factor/scenes.csv",
        "screen": "<results>/simulations/screen/scenes.csv",
        "design": "<results>/designs/four_factor.csv",
        "distinct": "<results>/designs/four_factor_distinct.csv",
    },
    "error_map": {
        "fit": "<results>/fits/two_factor_design.json",
        "forces": "<results>/simulations/error_map/forces.csv",
        "errors": "<results>/validation/two_factor_design_on_error_map.csv",
        "validation": "<results>/validation/two_factor_design_on_error_map.json",
        "design_forces": DESIGN_FORCES,
        "device": DEVICE,
    },
    "uncertainty": {
        "table": "<results>/tables/uncertainty.csv",
        "curves": "<results>/tables/uncertainty_curves.csv",
    },
    "overview": {
        "film": "<results>/simulations/extrapolation/film.csv",
        "film_forces": "<results>/simulations/extrapolation/forces.csv",
        "forces": SCREEN,
        "fit": "<results>/fits/screen.json",
        "design_forces": DESIGN_FORCES,
        "errors": "<results>/validation/two_factor_design_on_error_map.csv",
        "validation": "<results>/validation/two_factor_design_on_error_map.json",
    },
}
TABLE_INPUTS = {
    "1": {
        "first_fit": "<results>/fits/screen.json",
        "design_fit": "<results>/fits/two_factor_design.json",
        "design_on_first": f"{DESIGN_ON_SCREEN}.json",
        "forces": SCREEN,
        "device": DEVICE,
    },
    "2": {
        "screen": "<results>/simulations/screen/scenes.csv",
        "plan": "<results>/simulations/four_factor/scenes.csv",
    },
    "3": {
        "first_fit": "<results>/fits/four_factor.json",
        "design_fit": "<results>/fits/four_factor_design.json",
        "distinct_fit": "<results>/fits/four_factor_design_distinct.json",
        "design_on_first": "<results>/validation/four_factor_design_on_four_factor.json",
        "distinct_on_first": "<results>/validation/four_factor_design_distinct_on_four_factor.json",
        "forces": "<results>/simulations/four_factor/forces.csv",
        "device": DEVICE,
    },
}
CLAIM_INPUTS = {
    "screen": SCREEN,
    "screen_timings": "<results>/simulations/screen/timings.csv",
    "screen_fit": "<results>/fits/screen.json",
    "screen_runs": "<results>/fits/screen_runs.csv",
    "design": "<results>/designs/two_factor.csv",
    "design_summary": "<results>/designs/two_factor.json",
    "design_fit": "<results>/fits/two_factor_design.json",
    "screen_on_screen": "<results>/validation/screen_on_screen.json",
    "design_on_screen": f"{DESIGN_ON_SCREEN}.json",
    "design_errors": f"{DESIGN_ON_SCREEN}.csv",
    "extrapolation": "<results>/simulations/extrapolation/forces.csv",
    "four_factor": "<results>/simulations/four_factor/forces.csv",
    "four_factor_design": "<results>/designs/four_factor.csv",
    "four_factor_design_on_plan": "<results>/validation/four_factor_design_on_four_factor.json",
    "four_factor_distinct_on_plan": "<results>/validation/four_factor_design_distinct_on_four_factor.json",
    "four_factor_distinct_on_control": "<results>/validation/four_factor_design_distinct_on_four_factor_control.json",
}


FIGURE_SHOWS = {
    "fig05": "the model of the vibration over the surface",
    "fig06": "the same as a mesh",
    "fig07": "the screen: the simulations of the first plan",
    "fig08": "the model fitted to the screen",
    "fig09": "where the searches for an optimal design end",
    "fig10": "the first pattern of optimal points",
    "fig11": "the second pattern of optimal points",
    "fig12": "the optimal design in the space of the experiment",
    "fig13": "the model fitted to the optimal design",
    "fig14": "relative error of that model on the screen",
    "fig15": "the positions of the finger with four factors",
    "fig16": "the optimal design with four factors",
    "error_map": "relative error over the whole space",
    "uncertainty": "what would explain the difference from the paper's force",
    "overview": "what the whole study does",
}


wildcard_constraints:
    figure="|".join(FIGURE_INPUTS),
    number="[1-3]",


rule figure_data:
    input:
        unpack(lambda wildcards: FIGURE_INPUTS[wildcards.figure]),
        code=lambda wildcards: code("figure-data", room("figure_data", wildcards.figure)),
        config=ancient(CONFIG_FILE),
    output:
        "<results>/figures/{figure}.csv",
    log:
        "<logs>/figure_data/{figure}.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    threads: 1
    resources:
        mem_mb=500,
        runtime=5,
    params:
        settings=lambda wildcards: settings(room("figure_data", wildcards.figure)),
        room=lambda wildcards: room("figure_data", wildcards.figure),
        tables=lambda wildcards, input: " ".join(
            f"{name}={input[name]}" for name in FIGURE_INPUTS[wildcards.figure]
        ),
    message:
        "Data of {wildcards.figure}"
    shell:
        "python -m reporting figure-data {params.room} {params.tables} "
        "--config {input.config} --output {output} >{log} 2>&1"


rule plot:
    input:
        code=lambda wildcards: code("plot", room("figures", wildcards.figure)),
        data="<results>/figures/{figure}.csv",
    output:
        png="<results>/figures/{figure}.png",
        svg=report(
            "<results>/figures/{figure}.svg",
            category="3 Figures",
            labels=lambda wildcards: {
                "figure": wildcards.figure.replace("fig", "Fig. ").replace("_", " "),
                "shows": FIGURE_SHOWS[wildcards.figure],
            },
            caption="../report/figure.rst",
        ),
    log:
        "<logs>/plot/{figure}.log",
    localrule: True
    conda:
        "../../envs/figures.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        room=lambda wildcards: room("figures", wildcards.figure),
    message:
        "Draw {wildcards.figure}"
    shell:
        "python -m reporting plot {params.room} {input.data} "
        "--output {output.png} {output.svg} >{log} 2>&1"


rule table:
    input:
        unpack(lambda wildcards: TABLE_INPUTS[wildcards.number]),
        code=code("table"),
    output:
        csv="<results>/tables/table{number}.csv",
        markdown="<results>/tables/table{number}.md",
    log:
        "<logs>/table/table{number}.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    threads: 1
    resources:
        mem_mb=500,
        runtime=5,
    params:
        tables=lambda wildcards, input: " ".join(
            f"{name}={input[name]}" for name in TABLE_INPUTS[wildcards.number]
        ),
    message:
        "Table {wildcards.number}"
    shell:
        "python -m paper table {wildcards.number} {params.tables} "
        "--output {output.csv} --markdown {output.markdown} >{log} 2>&1"


rule compare_claims:
    input:
        **CLAIM_INPUTS,
        code=code("claims"),
    output:
        csv="<results>/claims.csv",
        markdown="<results>/claims.md",
    log:
        "<logs>/claims.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    threads: 1
    resources:
        mem_mb=500,
        runtime=5,
    params:
        tables=lambda wildcards, input: " ".join(f"{name}={input[name]}" for name in CLAIM_INPUTS),
    message:
        "The paper's claims beside ours"
    shell:
        "python -m paper claims {params.tables} "
        "--output {output.csv} --markdown {output.markdown} >{log} 2>&1"


# One short target a figure: `snakemake fig08` makes what Figure 8 needs and nothing else.
for name in FIGURE_INPUTS:

    rule:
        name:
            name
        input:
            expand("<results>/figures/{figure}.{format}", figure=name, format=["png", "svg"]),
        message:
            "{rule} is drawn"


rule figures:
    input:
        expand(
            "<results>/figures/{figure}.{format}",
            figure=FIGURE_INPUTS if PAPER else ["error_map", "overview"],
            format=["png", "svg"],
        ),
    message:
        "The study's figures are drawn"


rule tables:
    input:
        expand("<results>/tables/table{number}.{format}", number=TABLE_INPUTS, format=["csv", "md"]),
    message:
        "The paper's tables are made"


rule claims:
    input:
        "<results>/claims.csv",
        "<results>/claims.md",
    message:
        "The paper's claims are judged"

# From results to figures, tables and claims. A figure is a module, found in `figures` of a package.

from dataclasses import replace

from reporting.rooms import described, literal

CATEGORIES = {
    "figures": "3 Figures",
    "numerics": "4 Numerics",
    "models": "7 Models",
    "designs": "8 Designs and refinement",
    "refine": "8 Designs and refinement",
}
"""Of the report, by the folder that a figure lies in."""


def found_figures():
    """What every figure says of itself, by its place: one for each space where it has several."""
    packages = "*" if PAPER else "reporting"
    for path in sorted(LIBRARY.glob(f"{packages}/figures/[!_]*.py")):
        figure = described(path)
        if "{space}" not in figure.place:
            yield figure.place, figure
            continue
        for space, words in MODEL_SPACES.items():
            inputs = {name: file.format(space=space) for name, file in figure.inputs.items()}
            one = replace(figure, inputs=inputs, title=f"{figure.title}, {words}")
            yield one.place, one


try:
    FIGURES = dict(found_figures())
    TABLES = {
        path.stem.removeprefix("table"): described(path)
        for path in sorted(LIBRARY.glob("*/tables/[!_]*.py"))
    }
except InputError as error:
    refuse(error)
CLAIM_INPUTS = literal(LIBRARY / "paper" / "claims.py", "INPUTS")
# Those with a table of their own, and those drawn from a table that another stage makes.
OWN = [place for place, figure in FIGURES.items() if figure.builds]
STAGES = [place for place, figure in FIGURES.items() if not figure.builds]


def report_category(wildcards):
    return CATEGORIES[wildcards.place.partition("/")[0]]


def report_labels(wildcards):
    """How the report's list names a figure: the paper's by their numbers."""
    figure = FIGURES[wildcards.place]
    folder, _, name = wildcards.place.partition("/")
    if folder != "figures":
        return {"shows": figure.title}
    return {"figure": name.replace("fig", "Fig. ").replace("_", " "), "shows": figure.shows}


def among_results(inputs):
    """Files by name, where they lie."""
    return {name: f"<results>/{file}" for name, file in inputs.items()}


def named(inputs, files):
    """The words NAME=PATH of a command."""
    return " ".join(f"{name}={files[name]}" for name in inputs)


wildcard_constraints:
    number="|".join(TABLES),


rule figure:
    input:
        unpack(lambda wildcards: among_results(FIGURES[wildcards.place].inputs)),
        code=lambda wildcards: code("figure", FIGURES[wildcards.place].module),
        config=ancient(CONFIG_FILE),
    output:
        csv="<results>/{place}.csv",
        png="<results>/{place}.png",
        svg=report(
            "<results>/{place}.svg",
            category=report_category,
            labels=report_labels,
            caption="../report/figure.rst",
        ),
    log:
        "<logs>/plot/{place}.log",
    wildcard_constraints:
        place="|".join(OWN),
    localrule: True
    conda:
        "../../envs/figures.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        module=lambda wildcards: FIGURES[wildcards.place].module,
        caption=lambda wildcards: "**{0.title}.** {0.caption}".format(FIGURES[wildcards.place]),
        tables=lambda wildcards, input: named(FIGURES[wildcards.place].inputs, input),
    message:
        "Draw {wildcards.place}"
    shell:
        "python -m reporting figure {params.module} {params.tables} "
        "--config {input.config} --output {output} >{log} 2>&1"


use rule figure as plot with:
    output:
        png="<results>/{place}.png",
        svg=report(
            "<results>/{place}.svg",
            category=report_category,
            labels=report_labels,
            caption="../report/figure.rst",
        ),
    wildcard_constraints:
        place="|".join(STAGES),
    localrule: True


rule table:
    input:
        unpack(lambda wildcards: among_results(TABLES[wildcards.number].inputs)),
        code=lambda wildcards: code("table", TABLES[wildcards.number].module),
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
        tables=lambda wildcards, input: named(TABLES[wildcards.number].inputs, input),
    message:
        "Table {wildcards.number}"
    shell:
        "python -m paper table {wildcards.number} {params.tables} "
        "--output {output.csv} --markdown {output.markdown} >{log} 2>&1"


rule compare_claims:
    input:
        **among_results(CLAIM_INPUTS),
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
        tables=lambda wildcards, input: named(CLAIM_INPUTS, input),
    message:
        "The paper's claims beside ours"
    shell:
        "python -m paper claims {params.tables} "
        "--output {output.csv} --markdown {output.markdown} >{log} 2>&1"


# One short target a figure: `snakemake fig08` makes what Figure 8 needs and nothing else.
for place in OWN:

    rule:
        name:
            Path(place).name
        input:
            expand("<results>/{place}.{format}", place=place, format=["png", "svg"]),
        message:
            "{rule} is drawn"


rule figures:
    input:
        expand("<results>/{place}.{format}", place=OWN, format=["png", "svg"]),
    message:
        "The study's figures are drawn"


rule tables:
    input:
        expand("<results>/tables/table{number}.{format}", number=TABLES, format=["csv", "md"]),
    message:
        "The paper's tables are made"


rule claims:
    input:
        "<results>/claims.csv",
        "<results>/claims.md",
    message:
        "The paper's claims are judged"

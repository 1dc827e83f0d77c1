# From results to figures, tables and claims. A figure is a module, found in `figures` of a package.


wildcard_constraints:
    number="|".join(TABLES),


rule figure:
    input:
        unpack(lambda wildcards: among_results(FIGURES[wildcards.place].inputs)),
        config=ancient(CONFIG_FILE),
        profile=SMOOTHED,
    output:
        csv="<results>/{place}.csv",
        png="<results>/{place}.png",
        svg=report(
            "<results>/{place}.svg",
            category=report_category,
            labels=report_labels,
            caption="../report/figure.rst",
        ),
        plain="<results>/check/{place}.plain.png",
    log:
        "<logs>/plot/{place}.log",
    wildcard_constraints:
        place="|".join(OWN),
    localrule: True
    conda:
        "../../envs/figures.yaml"
    params:
        code=CODE["figures"],
        study=sections(*CONFIG),
        module=lambda wildcards: FIGURES[wildcards.place].module,
        caption=lambda wildcards: "**{0.title}.** {0.caption}".format(FIGURES[wildcards.place]),
        tables=lambda wildcards, input: named_inputs(FIGURES[wildcards.place].inputs, input),
    message:
        "Draw {wildcards.place}"
    shell:
        "python -m reporting figure {params.module} {params.tables} "
        "--config {input.config:q} --output {output:q} >{log:q} 2>&1"


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
    output:
        csv="<results>/tables/table{number}.csv",
        markdown="<results>/tables/table{number}.md",
    log:
        "<logs>/table/table{number}.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["figures"],
        tables=lambda wildcards, input: named_inputs(TABLES[wildcards.number].inputs, input),
    message:
        "Table {wildcards.number}"
    shell:
        "python -m paper table {wildcards.number} {params.tables} "
        "--output {output.csv:q} --markdown {output.markdown:q} >{log:q} 2>&1"


rule compare_claims:
    input:
        **among_results(CLAIM_INPUTS),
    output:
        csv="<results>/claims.csv",
        markdown="<results>/claims.md",
    log:
        "<logs>/claims.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["figures"],
        tables=lambda wildcards, input: named_inputs(CLAIM_INPUTS, input),
    message:
        "The paper's claims beside ours"
    shell:
        "python -m paper claims {params.tables} "
        "--output {output.csv:q} --markdown {output.markdown:q} >{log:q} 2>&1"


# One short target a figure: `snakemake fig08` makes what Figure 8 needs and nothing else.
for place in OWN:

    rule:
        name:
            Path(place).name
        input:
            files_of_figures([place]),
        message:
            "{rule} is drawn"


rule figures:
    input:
        files_of_figures(OWN),
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

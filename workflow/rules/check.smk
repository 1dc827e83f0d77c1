# A finished study beside its stored reference: `snakemake check`.

REFERENCE = LIBRARY.parent / "tests" / "reference" / STUDY


rule checked:
    input:
        rules.all.input,
        # The stiff and extreme films are part of the check where a sample of them is the study's.
        "<results>/numerics/stability.csv" if CONFIG["numerics"]["extent"] == "sample" else [],
    message:
        "All that a reference tells of is made"


# The table is made whatever the verdict: `check` alone fails, after it has shown it.
rule compare_with_reference:
    input:
        rules.checked.input,
        config=ancient(CONFIG_FILE),
        reference=[relative(path) for path in sorted(REFERENCE.glob("*.*"))],
    output:
        csv="<results>/check/check.csv",
        markdown="<results>/check/check.md",
    log:
        "<logs>/check/compare.log",
    localrule: True
    conda:
        "../../envs/figures.yaml"
    params:
        code=CODE["figures"],
        study=sections(*CONFIG),
        results=lambda wildcards, output: str(Path(output.csv).parents[1]),
        reference=lambda wildcards: relative(REFERENCE),
    message:
        "Every number beside its reference"
    shell:
        "python -m reporting check {params.results:q} --config {input.config:q} "
        "--reference {params.reference:q} --output {output.csv:q} --markdown {output.markdown:q} "
        "--keep-going >{log:q} 2>&1"


rule check:
    input:
        table="<results>/check/check.csv",
    log:
        "<logs>/check/verdict.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        code=CODE["figures"],
    message:
        "Is everything as in the reference?"
    shell:
        "python -m reporting verdict {input.table:q} 2>&1 | tee {log:q}"


use rule models_page as check_page with:
    input:
        config=ancient(CONFIG_FILE),
        tables="<results>/check/check.md",
    output:
        report(
            "<results>/report/check.html",
            category="5 Check",
            labels={"page": "Every number beside the stored reference"},
            caption="../report/check.rst",
        ),
    log:
        "<logs>/report/check.log",
    localrule: True
    message:
        "The check as a page"

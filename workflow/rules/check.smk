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
        code=code("check"),
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
        results=lambda wildcards, output: str(Path(output.csv).parents[1]),
        reference=lambda wildcards: relative(REFERENCE),
    message:
        "Every number beside its reference"
    shell:
        "python -m reporting check {params.results} --config {input.config} "
        "--reference {params.reference} --output {output.csv} --markdown {output.markdown} "
        "--keep-going >{log} 2>&1"


rule check:
    input:
        table="<results>/check/check.csv",
        code=code("verdict"),
    log:
        "<logs>/check/verdict.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    message:
        "Is everything as in the reference?"
    shell:
        "python -m reporting verdict {input.table} 2>&1 | tee {log}"


use rule models_page as check_page with:
    input:
        code=code("pages"),
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


# Run cards are read as they are when all else is made; this run's own is among them.
rule runs_page:
    input:
        rules.checked.input,
        pages_code=code("pages"),
        code=code("runs"),
    output:
        markdown="<results>/runs.md",
        html=report(
            "<results>/report/runs.html",
            category="6 Runs",
            labels={"page": "Code, settings, machines and files of every run"},
            caption="../report/runs.rst",
        ),
    log:
        "<logs>/report/runs.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    params:
        cards=f"results/{STUDY}/run_cards",
    message:
        "The runs that made all this, as a page"
    shell:
        "{{ python -m reporting runs {params.cards} --output {output.markdown} "
        "&& python -m reporting pages {output.markdown} --output {output.html}; }} >{log} 2>&1"

# A finished study beside its stored reference: `snakemake check`.

REFERENCE = LIBRARY.parent / "tests" / "reference" / STUDY


# The table is made whatever the verdict: `check` alone fails, after it has shown it.
rule compare_with_reference:
    input:
        rules.all.input,
        # The stiff and extreme films are part of the check where a sample of them is the study's.
        "<results>/numerics/stability.csv" if CONFIG["numerics"]["extent"] == "sample" else [],
        code=code("check"),
        config=ancient(CONFIG_FILE),
        reference=[relative(path) for path in sorted(REFERENCE.glob("*.csv"))],
    output:
        csv="<results>/check/check.csv",
        markdown="<results>/check/check.md",
    log:
        "<logs>/check/compare.log",
    localrule: True
    conda:
        "../../envs/figures.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        settings=settings("commands.check"),
        results=f"results/{STUDY}",
        reference=relative(REFERENCE),
    message:
        "Every number beside its reference"
    shell:
        "python -m squeezefilm check {params.results} --config {input.config} "
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
    threads: 1
    resources:
        mem_mb=500,
        runtime=5,
    message:
        "Is everything as in the reference?"
    shell:
        "python -m squeezefilm verdict {input.table} 2>&1 | tee {log}"


rule check_page:
    input:
        code=code("pages"),
        markdown="<results>/check/check.md",
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
    conda:
        "../../envs/tables.yaml"
    threads: 1
    resources:
        mem_mb=500,
        runtime=5,
    message:
        "The check as a page"
    shell:
        "python -m squeezefilm pages {input.markdown} --output {output} >{log} 2>&1"

# A finished study beside its stored reference: `snakemake check`.

REFERENCE = LIBRARY.parent / "tests" / "reference" / STUDY


rule checked:
    input:
        rules.all.input,
        # The stiff and extreme films are part of the check where a sample of them is the study's.
        "<results>/numerics/stability.csv" if CONFIG.numerics.extent == "sample" else [],
    message:
        "All that a reference tells of is made"


# The table is made whatever the verdict: `check` alone fails, after it has shown it.
rule compare_with_reference:
    input:
        rules.checked.input,
        reference=[relative(path) for path in sorted(REFERENCE.glob("*.*"))],
    output:
        csv="<results>/check/check.csv",
        text="<results>/check/check.txt",
        page=listed(
            "report/check.html",
            "5 Check",
            page="Every number beside the stored reference",
            caption="check",
        ),
    params:
        study=sections(),
        page="check",
        about=lambda wildcards: {"reference": relative(REFERENCE)},
    message:
        "Every number beside its reference"
    script:
        "../scripts/page.py"


rule check:
    input:
        rules.compare_with_reference.output.page,
        text=rules.compare_with_reference.output.text,
    log:
        "<logs>/check/verdict.log",
    message:
        "Is everything as in the reference?"
    shell:
        "tee {log:q} <{input.text:q} && grep -q '^All .* passed' {input.text:q}"

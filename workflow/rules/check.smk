# A finished study beside its stored reference: `snakemake check`.


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
        reference=reference_files,
    output:
        csv="<results>/check/check.csv",
        text="<results>/check/check.txt",
        page=listed(
            "report/check.html",
            CATEGORY["Check"],
            page="Results beside the stored reference",
            caption="check",
        ),
    log:
        "<logs>/compare_with_reference.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "page"),
        study=sections(),
        page="check",
        about=lambda wildcards: {"reference": in_folder(REFERENCE)},
    message:
        "Results beside the stored reference"
    script:
        "../scripts/page.py"


# The job that may fail has few inputs, all of which Snakemake lists; its log, which is shown last,
# has the verdict.
rule verdict:
    input:
        rules.compare_with_reference.output.page,
        text=rules.compare_with_reference.output.text,
    output:
        "<results>/check/passed.txt",
    log:
        "<logs>/check/verdict.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    message:
        "Is all that is compared as in the reference?"
    shell:
        "cp {input.text:q} {log:q} && grep -q '^All .* passed' {input.text:q} && cp {input.text:q} {output:q}"


# What was compared and the table are asked for too: made again where deleted, then judged again.
rule check:
    input:
        rules.checked.input,
        rules.compare_with_reference.output,
        passed=rules.verdict.output,
    log:
        "<logs>/check/shown.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    message:
        "All that is compared is as in the reference"
    shell:
        "tee {log:q} <{input.passed:q}"

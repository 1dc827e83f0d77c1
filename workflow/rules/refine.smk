# D-optimal designs with bounds of their efficiency (`optimal`), and the loop (`refine`).

REFINED = ["rounds.csv", "forces.csv", "limits.csv", "where.csv", "fit.json", "verdict.json"]


rule optimal_design:
    input:
        fit=lambda wildcards: f"<results>/fits/{FITS[wildcards.space][0]}.json",
        forces=lambda wildcards: f"<results>/simulations/{FITS[wildcards.space][0]}/forces.csv",
        patterns="<results>/designs/{space}.json",
        existing=lambda wildcards: f"<results>/simulations/{FITS[wildcards.space][-1]}/scenes.csv",
        plans=lambda wildcards: expand(
            "<results>/simulations/{plan}/scenes.csv", plan=FITS[wildcards.space]
        ),
    output:
        designs="<results>/designs/optimal_{space}.csv",
        efficiencies="<results>/designs/optimal_{space}_plans.csv",
        sensitivity="<results>/designs/optimal_{space}_sensitivity.csv",
        summary="<results>/designs/optimal_{space}.json",
    log:
        "<logs>/optimal_design/{space}.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("models", "optimal_designs"),
        study=sections("screen", "positions", "optimal", *FILM),
    message:
        "D-optimal designs of the {wildcards.space} model, with bounds of their efficiency"
    script:
        "../scripts/optimal_designs.py"


rule optimal:
    input:
        expand(rules.optimal_design.output, space=FITS),
        [pictures(f"designs/optimal_{space}_sensitivity") for space in FITS],
    message:
        "Designs are certified, and other plans compared with them"


rule refine_model:
    input:
        kernels="<results>/simulations/device.json",
        sample="<results>/simulations/validation_{space}/forces.csv",
        scan=SCAN_SUMMARY,
    output:
        **{Path(name).stem: f"<results>/refine/{{space}}/{{model}}/{name}" for name in REFINED},
    log:
        "<logs>/refine_model/{model}/{space}.log",
    benchmark:
        "<benchmarks>/refine_model/{model}/{space}.tsv"
    conda:
        "../../envs/workflow.yaml"
    resources:
        mem_mb=growing(2000),
        runtime=growing(60),
    params:
        code=code_of("models", "refine"),
        study=sections("solver", "screen", "positions", "fit", "models", "refine", *FILM),
    message:
        "Refine {wildcards.model} over the {wildcards.space} space"
    script:
        "../scripts/refine.py"


rule refine_report:
    input:
        lambda wildcards: refined_files(wildcards.space),
        forces="<results>/simulations/validation_{space}/forces.csv",
        limits="<results>/simulations/validation_{space}/limits.csv",
    output:
        table="<results>/refine/{space}.csv",
        page=listed(
            "refine/{space}.html",
            CATEGORY["Designs and refinement"],
            caption="refine",
            shows="table, {space}",
        ),
    log:
        "<logs>/refine_report/{space}.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "page"),
        study=sections("refine", "screen", *FILM),
        page="refine",
    message:
        "Estimated errors over the {wildcards.space} space beside those at held-out points"
    script:
        "../scripts/page.py"


rule refine:
    input:
        [refined_files(space) for space in FITS],
        expand(rules.refine_report.output, space=FITS),
        [pictures(f"refine/{space}_figure") for space in FITS],
    message:
        "Models are refined until they are good enough, or their limit is known"

# Where to simulate, with a certificate: `snakemake optimal`; and the loop closed: `snakemake refine`.

# The fit whose model designs are made for, the forces behind it, and the plans judged beside them.
OPTIMAL_FIT = {"two_factor": "screen", "four_factor": "four_factor"}
JUDGED_PLANS = {
    "two_factor": ["screen", "two_factor_design"],
    "four_factor": ["four_factor", "four_factor_design", "four_factor_design_distinct"],
}
EXTENDED_PLAN = {"two_factor": "two_factor_design", "four_factor": "four_factor_design_distinct"}
OPTIMAL_CODE = {space: code("optimal", key=space) for space in MODEL_SPACES}
REFINE_CODE = {space: code("refine", key=space) for space in MODEL_SPACES}
REFINED = ["rounds.csv", "forces.csv", "limits.csv", "where.csv", "fit.json", "verdict.json"]


rule optimal_design:
    input:
        code=lambda wildcards: OPTIMAL_CODE[wildcards.space],
        config=ancient(CONFIG_FILE),
        fit=lambda wildcards: f"<results>/fits/{OPTIMAL_FIT[wildcards.space]}.json",
        forces=lambda wildcards: (
            f"<results>/simulations/{OPTIMAL_FIT[wildcards.space]}/forces.csv"
        ),
        patterns="<results>/designs/{space}.json",
        existing=lambda wildcards: (
            f"<results>/simulations/{EXTENDED_PLAN[wildcards.space]}/scenes.csv"
        ),
        plans=lambda wildcards: [
            f"<results>/simulations/{plan}/scenes.csv" for plan in JUDGED_PLANS[wildcards.space]
        ],
    output:
        designs="<results>/designs/optimal_{space}.csv",
        plans="<results>/designs/optimal_{space}_plans.csv",
        sensitivity="<results>/designs/optimal_{space}_sensitivity.csv",
        summary="<results>/designs/optimal_{space}.json",
    log:
        "<logs>/design/optimal_{space}.log",
    localrule: True
    conda:
        "../../envs/numerics.yaml"
    params:
        plans=lambda wildcards, input: " ".join(
            f"{name}={path}"
            for name, path in zip(JUDGED_PLANS[wildcards.space], input.plans, strict=True)
        ),
    message:
        "D-optimal designs of the {wildcards.space} model, with a certificate"
    shell:
        "python -m squeezefilm optimal {input.fit} --forces {input.forces} "
        "--config {input.config} --plans {params.plans} --patterns {input.patterns} "
        "--existing {input.existing} --output {output.designs} --efficiencies {output.plans} "
        "--sensitivity {output.sensitivity} --summary {output.summary} >{log} 2>&1"


rule optimal:
    input:
        expand(
            "<results>/designs/optimal_{space}.{format}",
            space=MODEL_SPACES,
            format=["csv", "json"],
        ),
        expand("<results>/designs/optimal_{space}_plans.csv", space=MODEL_SPACES),
        expand(
            "<results>/designs/optimal_{space}_sensitivity.{format}",
            space=MODEL_SPACES,
            format=["csv", "png", "svg"],
        ),
    message:
        "Designs are certified, and other plans judged beside them"


rule refine_model:
    input:
        code=lambda wildcards: REFINE_CODE[wildcards.space],
        config=ancient(CONFIG_FILE),
        kernels="<results>/simulations/device.json",
        sample="<results>/simulations/validation_{space}/forces.csv",
        sample_limits="<results>/simulations/validation_{space}/limits.csv",
        scan=SCAN_SUMMARY,
    output:
        rounds="<results>/refine/{space}/{model}/rounds.csv",
        forces="<results>/refine/{space}/{model}/forces.csv",
        limits="<results>/refine/{space}/{model}/limits.csv",
        where="<results>/refine/{space}/{model}/where.csv",
        fit="<results>/refine/{space}/{model}/fit.json",
        verdict="<results>/refine/{space}/{model}/verdict.json",
    log:
        "<logs>/refine/{space}/{model}.log",
    benchmark:
        "<benchmarks>/refine/{space}/{model}.tsv"
    conda:
        "../../envs/numerics.yaml"
    resources:
        mem_mb=2000,
        runtime=60,
    message:
        "Refine {wildcards.model} over the {wildcards.space} space"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} python -m squeezefilm refine {wildcards.model} "
        f"{WITH_SCAN}--sample {{input.sample}} --sample-limits {{input.sample_limits}} "
        "--space {wildcards.space} --config {input.config} --rounds {output.rounds} "
        "--forces {output.forces} --limits {output.limits} --fit {output.fit} "
        "--where {output.where} --keep-going --output {output.verdict} >{log} 2>&1"


rule refine_report:
    input:
        code=code("refine-report"),
        refined=lambda wildcards: [
            f"<results>/refine/{wildcards.space}/{model}/{name}"
            for model in CONFIG["refine"][wildcards.space]
            for name in REFINED
        ],
        forces="<results>/simulations/validation_{space}/forces.csv",
        limits="<results>/simulations/validation_{space}/limits.csv",
    output:
        table="<results>/refine/{space}.csv",
        text="<results>/refine/{space}.md",
        figure="<results>/refine/{space}_figure.csv",
    log:
        "<logs>/refine/report_{space}.log",
    localrule: True
    conda:
        "../../envs/fit.yaml"
    params:
        folders=lambda wildcards, input: " ".join(
            str(Path(path).parent) for path in input.refined if Path(path).name == "verdict.json"
        ),
    message:
        "What was estimated over the {wildcards.space} space, and the truth"
    shell:
        "python -m reporting refine-report {params.folders} --forces {input.forces} "
        "--limits {input.limits} --output {output.table} --report {output.text} "
        "--figure {output.figure} >{log} 2>&1"


use rule models_page as refine_page with:
    input:
        code=code("pages"),
        config=ancient(CONFIG_FILE),
        tables=expand("<results>/refine/{space}.md", space=MODEL_SPACES),
    output:
        [
            report(
                f"<results>/refine/{space}.html",
                category="8 Designs and refinement",
                labels={"shows": f"table, {shows}"},
                caption="../report/refine.rst",
            )
            for space, shows in MODEL_SPACES.items()
        ],
    log:
        "<logs>/refine/pages.log",
    localrule: True
    message:
        "The refinement as pages"


rule refine:
    input:
        rules.refine_page.output,
        expand(
            "<results>/refine/{space}{file}",
            space=MODEL_SPACES,
            file=[".csv", ".md", "_figure.png", "_figure.svg"],
        ),
    message:
        "Models are refined until they are good enough, or their limit is known"

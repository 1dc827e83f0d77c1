# Candidates for the force model, the paper's, physics and your own, side by side: `snakemake models`.

# Plans that validate the recommended model; the first has the positions.
RECOMMENDED_BY = ["four_factor", *expand("validation_{space}", space=FITS)]


wildcard_constraints:
    space="|".join(FITS),
    model="[a-z][a-z0-9_]*",


rule limit_table:
    input:
        profile=SMOOTHED,
    output:
        "<results>/models/limit_table.json",
    log:
        "<logs>/limit_table.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("models", "limit_table"),
        study=sections("screen", "positions", *FILM),
    message:
        "Asymptotic forces over the space, for models that use them"
    script:
        "../scripts/limit_table.py"


# All of a space and the asymptotic forces at its points: a process takes longer to start than to fit.
for space, (plan, *_) in FITS.items():

    rule:
        name:
            f"fit_candidates_{space}"
        input:
            forces=f"<results>/simulations/{plan}/forces.csv",
            sample=f"<results>/simulations/validation_{space}/forces.csv",
            limit_table=rules.limit_table.output[0],
            scan=SCAN_SUMMARY,
        output:
            fits=candidate_files(space),
            limits=limit_tables(space),
        log:
            f"<logs>/fit_candidates_{space}.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("models", "fit"),
            study=sections("fit", "models", "screen", "positions", *FILM),
            models=candidates(space),
            seeds=1,
        message:
            f"Fit candidates to {space} points"
        script:
            "../scripts/fit.py"


# All spaces and what is recommended of them: a process takes longer to start than to compare.
rule compare:
    input:
        [candidate_files(space) for space in FITS],
        [limit_tables(space) for space in FITS],
        [f"<results>/fits/{plan}.json" for plan, *_ in FITS.values()],
        expand("<results>/simulations/{plan}/forces.csv", plan=["screen", *RECOMMENDED_BY]),
    output:
        tables=expand("<results>/models/{space}.csv", space=FITS),
        errors=expand("<results>/models/{space}_errors.csv", space=FITS),
        pages=[
            listed(
                f"models/{space}.html",
                CATEGORY["Models"],
                caption="models",
                shows=f"table, {space}",
            )
            for space in FITS
        ],
        recommended="<results>/models/recommended.csv",
    log:
        "<logs>/compare.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("figures", "compare"),
        study=sections("comparison", "extrapolation", "screen", *FILM),
        spaces=list(FITS),
    message:
        "Candidates side by side, the best, and its amplitude for the target force"
    script:
        "../scripts/compare.py"


rule models:
    input:
        rules.limit_table.output,
        [limit_tables(space) for space in FITS],
        [candidate_files(space) for space in FITS],
        rules.compare.output,
        [pictures(f"models/{space}_errors") for space in FITS],
    message:
        "Compared in results/{STUDY}/models; `squeezefilm recommend results/{STUDY}` names the best"

# How well a fit predicts simulated forces, those it was fitted on and others; and the targets
# that end with it.

VALIDATIONS_TWO_FACTOR = [
    "screen_on_screen",
    "screen_on_error_map",
    "screen_on_extrapolation",
    "two_factor_design_on_screen",
    "two_factor_design_on_error_map",
    "two_factor_design_on_extrapolation",
]
VALIDATIONS_FOUR_FACTOR = [
    "four_factor_on_four_factor",
    "four_factor_on_four_factor_control",
    "four_factor_design_on_four_factor",
    "four_factor_design_on_four_factor_control",
    "four_factor_design_distinct_on_four_factor",
    "four_factor_design_distinct_on_four_factor_control",
]


rule validate:
    input:
        code=code("validate"),
        config=ancient(CONFIG_FILE),
        fit="<results>/fits/{fit}.json",
        forces="<results>/simulations/{plan}/forces.csv",
    output:
        errors="<results>/validation/{fit}_on_{plan}.csv",
        summary="<results>/validation/{fit}_on_{plan}.json",
    log:
        "<logs>/validate/{fit}_on_{plan}.log",
    localrule: True
    conda:
        "../../envs/tables.yaml"
    message:
        "Judge the fit {wildcards.fit} on {wildcards.plan}"
    shell:
        "python -m squeezefilm validate {input.fit} {input.forces} --config {input.config} "
        "--output {output.errors} --summary {output.summary} >{log} 2>&1"


rule two_factor:
    input:
        expand("<results>/validation/{pair}.json", pair=VALIDATIONS_TWO_FACTOR),
    message:
        "The two-factor model is fitted, designed and judged"


rule four_factor:
    input:
        expand("<results>/validation/{pair}.json", pair=VALIDATIONS_FOUR_FACTOR),
    message:
        "The four-factor model is fitted, designed and judged"

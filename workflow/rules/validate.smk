# How well a fit predicts simulated forces, those it was fitted on and others; and the targets
# that end with it.

PLANS_TWO_FACTOR = ["screen", "error_map", "extrapolation"]
PLANS_FOUR_FACTOR = ["four_factor", *(["four_factor_control"] if PAPER else [])]
DESIGNED_PLANS = ["four_factor_design", "four_factor_design_distinct"]
VALIDATIONS_TWO_FACTOR = validations("two_factor", PLANS_TWO_FACTOR)
VALIDATIONS_FOUR_FACTOR = validations("four_factor", PLANS_FOUR_FACTOR)


# Of one fit on all its sets of points: a process takes longer to start than to judge.
rule validate_two_factor:
    input:
        fit="<results>/fits/{fit}.json",
        forces=expand("<results>/simulations/{plan}/forces.csv", plan=PLANS_TWO_FACTOR),
    output:
        errors=expand("<results>/validation/{{fit}}_on_{plan}.csv", plan=PLANS_TWO_FACTOR),
        summary=expand("<results>/validation/{{fit}}_on_{plan}.json", plan=PLANS_TWO_FACTOR),
    params:
        code=CODE["models"],
        study=sections("validation"),
    message:
        "Judge the fit {wildcards.fit}"
    script:
        "../scripts/validate.py"


use rule validate_two_factor as validate_four_factor with:
    input:
        fit="<results>/fits/{fit}.json",
        forces=expand("<results>/simulations/{plan}/forces.csv", plan=PLANS_FOUR_FACTOR),
    output:
        errors=expand("<results>/validation/{{fit}}_on_{plan}.csv", plan=PLANS_FOUR_FACTOR),
        summary=expand("<results>/validation/{{fit}}_on_{plan}.json", plan=PLANS_FOUR_FACTOR),


rule two_factor:
    input:
        files_of_plans([*PLANS_TWO_FACTOR, "two_factor_design", "validation_two_factor"]),
        files_of_fits("two_factor"),
        rules.design_two_factor.output,
        expand(
            "<results>/validation/{pair}.{format}",
            pair=VALIDATIONS_TWO_FACTOR,
            format=["csv", "json"],
        ),
    message:
        "The two-factor model is fitted, designed and judged"


rule four_factor:
    input:
        files_of_plans([*PLANS_FOUR_FACTOR, *DESIGNED_PLANS, "validation_four_factor"]),
        files_of_fits("four_factor"),
        rules.design_four_factor.output,
        expand(
            "<results>/validation/{pair}.{format}",
            pair=VALIDATIONS_FOUR_FACTOR,
            format=["csv", "json"],
        ),
    message:
        "The four-factor model is fitted, designed and judged"

# How well a fit predicts simulated forces, those it was fitted on and others; and the targets
# that end with it.


# Of one fit on all its sets of points: a process takes longer to start than to judge.
for space, plans in JUDGED_ON.items():

    rule:
        name:
            f"validate_{space}"
        input:
            fit="<results>/fits/{fit}.json",
            forces=expand("<results>/simulations/{plan}/forces.csv", plan=plans),
        output:
            errors=expand("<results>/validation/{{fit}}_on_{plan}.csv", plan=plans),
            summary=expand("<results>/validation/{{fit}}_on_{plan}.json", plan=plans),
        params:
            code=CODE["models"],
            study=sections("validation"),
        message:
            "Judge the fit {wildcards.fit}"
        script:
            "../scripts/validate.py"


rule two_factor:
    input:
        files_of_space("two_factor"),
        rules.design_two_factor.output,
    message:
        "The two-factor model is fitted, designed and judged"


rule four_factor:
    input:
        files_of_space("four_factor"),
        rules.design_four_factor.output,
    message:
        "The four-factor model is fitted, designed and judged"

# How well a fit predicts simulated forces, those it was fitted on and others; and the targets
# that end with it.


# All fits on all sets of points: a process takes longer to start than to validate.
for space, plans in JUDGED_ON.items():

    rule:
        name:
            f"validate_{space}"
        input:
            fits=expand("<results>/fits/{fit}.json", fit=FITS[space]),
            forces=expand("<results>/simulations/{plan}/forces.csv", plan=plans),
        output:
            errors=expand("<results>/validation/{pair}.csv", pair=validations(space)),
            summary=expand("<results>/validation/{pair}.json", pair=validations(space)),
        log:
            f"<logs>/validate_{space}.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("models", "validate"),
            study=sections("validation"),
        message:
            f"Validate the fits of the {space} model"
        script:
            "../scripts/validate.py"

    rule:
        name:
            space
        input:
            expand(
                "<results>/simulations/{plan}/{name}.csv",
                plan=[*plans, *FITS[space], f"validation_{space}"],
                name=["scenes", "forces", "timings"],
            ),
            expand("<results>/fits/{fit}{end}", fit=FITS[space], end=[".json", "_runs.csv"]),
            getattr(rules, f"validate_{space}").output,
            getattr(rules, f"design_{space}").output,
        message:
            f"The {space.replace('_', '-')} model is fitted, designed and validated"

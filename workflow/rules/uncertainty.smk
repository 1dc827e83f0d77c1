# What the differences from the paper may rest on, and a film to look at.


if PAPER:

    rule uncertainty_table:
        input:
            kernels="<results>/simulations/device.json",
        output:
            csv="<results>/tables/uncertainty.csv",
            markdown="<results>/tables/uncertainty.md",
            curves="<results>/tables/uncertainty_curves.csv",
            page=listed(
                "report/uncertainty.html",
                SUMMARY,
                page="3 Uncertainty: what would explain a difference from the paper",
                caption="uncertainty",
            ),
        params:
            study=sections("solver", "screen", "extrapolation", *FILM),
        message:
            "What would explain the differences from the paper"
        script:
            "../scripts/uncertainty.py"


rule cross_section:
    input:
        profile=SMOOTHED,
        scenes="<results>/simulations/extrapolation/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        "<results>/simulations/extrapolation/film.csv",
    params:
        study=sections("solver", *FILM),
    message:
        "Gap and pressure under the finger over a period"
    script:
        "../scripts/cross_section.py"

# What the differences from the paper may rest on, and a film to look at.


if PAPER:

    rule uncertainty_table:
        input:
            kernels="<results>/simulations/device.json",
        output:
            csv="<results>/tables/uncertainty.csv",
            markdown="<results>/tables/uncertainty.md",
            curves="<results>/tables/uncertainty_curves.csv",
            page=report(
                "<results>/report/uncertainty.html",
                category="1 Summary and claims",
                labels={"page": "3 Uncertainty: what would explain a difference from the paper"},
                caption="../report/captions/uncertainty.rst",
            ),
        log:
            "<logs>/table/uncertainty.log",
        params:
            code=CODE["figures"],
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
    log:
        "<logs>/cross_section.log",
    params:
        code=CODE["figures"],
        study=sections("solver", *FILM),
    message:
        "Gap and pressure under the finger over a period"
    script:
        "../scripts/cross_section.py"

# From a fitted model to the points at which simulations teach most.


rule design_two_factor:
    input:
        fit="<results>/fits/screen.json",
    output:
        design="<results>/designs/two_factor.csv",
        searches="<results>/designs/two_factor_searches.csv",
        summary="<results>/designs/two_factor.json",
    log:
        "<logs>/design_two_factor.log",
    priority: 2
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    threads: cores_for(CONFIG.design.searches)
    params:
        code=code_of("models", "design"),
        study=sections("design", "screen"),
    message:
        "D-optimal searches with the two-factor model"
    script:
        "../scripts/design.py"


use rule design_two_factor as design_four_factor with:
    input:
        fit="<results>/fits/four_factor.json",
    output:
        paper="<results>/designs/four_factor.csv",
        distinct="<results>/designs/four_factor_distinct.csv",
        summary="<results>/designs/four_factor.json",
    log:
        "<logs>/design_four_factor.log",
    threads: cores_for(CONFIG.four_factor_design.searches)
    params:
        code=code_of("models", "design"),
        study=sections("four_factor_design", "positions", "screen", *SHAPES),
    message:
        "D-optimal searches with the four-factor model"

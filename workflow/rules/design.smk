# From a fitted model to the points at which simulations teach most.


rule design_two_factor:
    input:
        fit="<results>/fits/screen.json",
    output:
        design="<results>/designs/two_factor.csv",
        searches="<results>/designs/two_factor_searches.csv",
        summary="<results>/designs/two_factor.json",
    priority: 2
    threads: cores_for(CONFIG.design.searches)
    params:
        code=CODE["models"],
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
    threads: cores_for(CONFIG.four_factor_design.searches)
    params:
        code=CODE["models"],
        study=sections("four_factor_design", "positions", "screen", *SHAPES),
    message:
        "D-optimal searches with the four-factor model"

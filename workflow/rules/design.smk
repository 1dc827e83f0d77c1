# From a fitted model to the points at which simulations teach most.


rule design_two_factor:
    input:
        config=ancient(CONFIG_FILE),
        fit="<results>/fits/screen.json",
    output:
        design="<results>/designs/two_factor.csv",
        searches="<results>/designs/two_factor_searches.csv",
        summary="<results>/designs/two_factor.json",
    log:
        "<logs>/design/two_factor.log",
    localrule: True
    conda:
        "../../envs/fit.yaml"
    threads: cores_for(CONFIG["design"]["searches"])
    params:
        code=CODE["models"],
        study=sections("design", "screen"),
    message:
        "D-optimal searches with the two-factor model"
    shell:
        "python -m squeezefilm design two-factor {input.fit:q} --config {input.config:q} "
        "--processes {threads} --output {output.design:q} --searches {output.searches:q} --summary {output.summary:q} "
        ">{log:q} 2>&1"


rule design_four_factor:
    input:
        config=ancient(CONFIG_FILE),
        fit="<results>/fits/four_factor.json",
    output:
        design="<results>/designs/four_factor.csv",
        distinct="<results>/designs/four_factor_distinct.csv",
        searches="<results>/designs/four_factor_searches.csv",
        summary="<results>/designs/four_factor.json",
    log:
        "<logs>/design/four_factor.log",
    localrule: True
    conda:
        "../../envs/fit.yaml"
    threads: cores_for(CONFIG["four_factor_design"]["searches"])
    params:
        code=CODE["models"],
        study=sections("four_factor_design", "positions", "screen", *SHAPES),
    message:
        "D-optimal searches with the four-factor model"
    shell:
        "python -m squeezefilm design four-factor {input.fit:q} --config {input.config:q} "
        "--processes {threads} --output {output.design:q} --distinct {output.distinct:q} --searches {output.searches:q} "
        "--summary {output.summary:q} >{log:q} 2>&1"

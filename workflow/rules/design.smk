# From a fitted model to the points at which simulations teach most.


rule design_two_factor:
    input:
        code=code("design", key="two-factor"),
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
    message:
        "D-optimal searches with the two-factor model"
    shell:
        "python -m squeezefilm design two-factor {input.fit} --config {input.config} "
        "--processes {threads} --output {output.design} --searches {output.searches} --summary {output.summary} "
        ">{log} 2>&1"


rule design_four_factor:
    input:
        code=code("design", key="four-factor"),
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
    message:
        "D-optimal searches with the four-factor model"
    shell:
        "python -m squeezefilm design four-factor {input.fit} --config {input.config} "
        "--processes {threads} --output {output.design} --distinct {output.distinct} --searches {output.searches} "
        "--summary {output.summary} >{log} 2>&1"

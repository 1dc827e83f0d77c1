# What the differences from the paper may rest on, and a film to look at.


rule uncertainty_table:
    input:
        config=ancient(CONFIG_FILE),
        kernels="<results>/simulations/device.json",
    output:
        csv="<results>/tables/uncertainty.csv",
        markdown="<results>/tables/uncertainty.md",
        curves="<results>/tables/uncertainty_curves.csv",
    log:
        "<logs>/table/uncertainty.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["figures"],
        study=sections("solver", "screen", "extrapolation", *FILM),
    message:
        "What would explain the differences from the paper"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} python -m paper uncertainty "
        "--config {input.config:q} --output {output.csv:q} --markdown {output.markdown:q} "
        "--curves {output.curves:q} >{log:q} 2>&1"


rule cross_section:
    input:
        config=ancient(CONFIG_FILE),
        scenes="<results>/simulations/extrapolation/scenes.csv",
        kernels="<results>/simulations/device.json",
    output:
        "<results>/simulations/extrapolation/film.csv",
    log:
        "<logs>/cross_section.log",
    localrule: True
    conda:
        "../../envs/simulate.yaml"
    params:
        code=CODE["figures"],
        study=sections(*FILM),
    message:
        "Gap and pressure under the finger over a period"
    shell:
        "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
        "python -m reporting cross-section {input.scenes:q} "
        "--config {input.config:q} --output {output:q} >{log:q} 2>&1"

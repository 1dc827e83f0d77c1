# Your measured forces beside computed ones: `snakemake measurements`.


rule compare_measurements:
    input:
        table=ancient(source_file(CONFIG.path.parent / MEASURED)) if MEASURED else [],
        kernels=rules.compile_kernels.output,
    output:
        comparison="<results>/measurements/comparison.csv",
        summary="<results>/measurements/summary.json",
    log:
        "<logs>/compare_measurements.log",
    localrule: True
    conda:
        "../../envs/workflow.yaml"
    params:
        code=code_of("solver", "measurements"),
        study=sections("solver", *FILM, *(["measurements"] if MEASURED else [])),
    message:
        "Measured forces beside computed ones"
    script:
        "../scripts/measurements.py"


rule measurements:
    input:
        rules.compare_measurements.output,
        pictures("figures/measurements"),

# Your measured forces beside computed ones: `snakemake measurements`.


rule compare_measurements:
    input:
        table=ancient(relative(CONFIG.path.parent / MEASURED)) if MEASURED else [],
        kernels=rules.compile_kernels.output,
    output:
        comparison="<results>/measurements/comparison.csv",
        summary="<results>/measurements/summary.json",
    params:
        code=CODE["solver"],
        study=sections("solver", *FILM, *(["measurements"] if MEASURED else [])),
    message:
        "Measured forces beside computed ones"
    script:
        "../scripts/measurements.py"


rule measurements:
    input:
        rules.compare_measurements.output,
        pictures("figures/measurements"),

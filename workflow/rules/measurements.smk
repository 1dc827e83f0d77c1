# Your measured forces beside computed ones: `snakemake measurements`.

MEASURED_FILES = ["measurements/comparison.csv", "measurements/summary.json"]

if MEASURED:

    rule compare_measurements:
        input:
            table=ancient(relative(CONFIG.path.parent / MEASURED)),
            kernels=rules.compile_kernels.output,
        output:
            expand("<results>/{file}", file=MEASURED_FILES),
        params:
            code=CODE["solver"],
            study=sections("measurements", "solver", *FILM),
        message:
            "Measured forces beside computed ones"
        script:
            "../scripts/measurements.py"

    rule measurements:
        input:
            rules.compare_measurements.output,
            expand("<results>/figures/measurements.{format}", format=["png", "svg"]),
        message:
            "Measured forces stand beside computed ones in results/{STUDY}/measurements"

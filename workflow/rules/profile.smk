# A measured vibration profile, smoothed, and what its noise does: `snakemake profile`.

if SCAN:

    # Refusals are for the terminal: everything else waits for this.
    rule smooth:
        input:
            config=ancient(CONFIG_FILE),
            scan=ancient(relative(CONFIG.path.parent / SCAN)),
        output:
            SMOOTHED,
        log:
            "<logs>/smooth.log",
        conda:
            "../../envs/tables.yaml"
        resources:
            mem_mb=4000,
            runtime=30,
        params:
            code=CODE["solver"],
            study=sections("actuator"),
        message:
            "Make a smooth profile of the scan"
        shell:
            "python -m squeezefilm smooth --config {input.config:q} --output {output:q} >{log:q} 2>&1 "
            "|| {{ cat {log:q} >&2; exit 1; }}"

    rule smooth_profile:
        input:
            config=ancient(CONFIG_FILE),
            kernels="<results>/simulations/device.json",
        output:
            summary="<results>/profile/summary.json",
            forces="<results>/profile/forces.csv",
            figure="<results>/figures/profile.csv",
        log:
            "<logs>/profile.log",
        conda:
            "../../envs/simulate.yaml"
        resources:
            mem_mb=2000,
            runtime=30,
        params:
            code=CODE["solver"],
            study=sections("solver", "screen", "positions", *FILM),
        message:
            "Smooth the measured profile; simulate it with other noise"
        shell:
            "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
            "python -m squeezefilm profile "
            "--config {input.config:q} --summary {output.summary:q} "
            "--forces {output.forces:q} --figure {output.figure:q} >{log:q} 2>&1"

    rule profile:
        input:
            SMOOTHED,
            rules.smooth_profile.output,
            expand("<results>/figures/profile.{format}", format=["png", "svg"]),
        message:
            "The measured profile is smooth, and its noise is weighed"

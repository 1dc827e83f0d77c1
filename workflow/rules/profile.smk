# A measured vibration profile, smoothed, and what its noise does: `snakemake profile`.

if SCAN:

    # Everything else waits for this.
    rule smooth:
        input:
            scan=ancient(source_file(CONFIG.path.parent / SCAN)),
        output:
            SMOOTHED,
        log:
            "<logs>/smooth.log",
        benchmark:
            "<benchmarks>/smooth.tsv"
        conda:
            "../../envs/workflow.yaml"
        resources:
            mem_mb=growing(4000),
            runtime=growing(30),
        params:
            code=code_of("solver", "smooth"),
            study=sections("actuator"),
        message:
            "Make a smooth profile of the scan"
        script:
            "../scripts/smooth.py"

    rule smooth_profile:
        input:
            kernels="<results>/simulations/device.json",
        output:
            summary="<results>/profile/summary.json",
            forces="<results>/profile/forces.csv",
            figure="<results>/figures/profile.csv",
        log:
            "<logs>/smooth_profile.log",
        benchmark:
            "<benchmarks>/smooth_profile.tsv"
        conda:
            "../../envs/workflow.yaml"
        resources:
            mem_mb=growing(2000),
            runtime=growing(30),
        params:
            code=code_of("solver", "profile"),
            study=sections("solver", "screen", "positions", *FILM),
        message:
            "Smooth the measured profile; simulate it with other noise"
        script:
            "../scripts/profile.py"

    rule profile:
        input:
            SMOOTHED,
            rules.smooth_profile.output,
            pictures("figures/profile"),
        message:
            "The measured profile is smooth, and its noise is weighed"

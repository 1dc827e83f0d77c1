# A measured vibration profile, smoothed, and what its noise does: `snakemake profile`.

if SCAN:

    # Everything else waits for this.
    rule smooth:
        input:
            scan=ancient(relative(CONFIG.path.parent / SCAN)),
        output:
            SMOOTHED,
        resources:
            mem_mb=4000,
            runtime=30,
        params:
            code=CODE["solver"],
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
        resources:
            mem_mb=2000,
            runtime=30,
        params:
            code=CODE["solver"],
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

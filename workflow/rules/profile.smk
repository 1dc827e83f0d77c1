# A measured vibration profile, smoothed, and what its noise does: `snakemake profile`.

if SCAN:

    rule smooth_profile:
        input:
            code=code("profile"),
            config=ancient(CONFIG_FILE),
            kernels="<results>/simulations/device.json",
        output:
            points="<results>/profile/points.csv",
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
        message:
            "Smooth the measured profile; simulate it with other noise"
        shell:
            "POCL_MAX_PTHREAD_COUNT={threads} OPENBLAS_NUM_THREADS={threads} "
            "python -m squeezefilm profile "
            "--config {input.config} --points {output.points} --summary {output.summary} "
            "--forces {output.forces} --figure {output.figure} >{log} 2>&1"

    rule profile:
        input:
            rules.smooth_profile.output,
            expand("<results>/figures/profile.{format}", format=["png", "svg"]),
        message:
            "The measured profile is smooth, and its noise is weighed"

"""What the Makefile hands to snakemake, and that the docs say the same."""

import subprocess
from pathlib import Path

PROFILE = "--workflow-profile profiles/slurm"


def commands(repository: Path, *words: str) -> list[str]:
    """The lines of snakemake that `make` would run."""
    done = subprocess.run(
        ["make", "--dry-run", "--old-file", ".venv/.run", *words],
        cwd=repository,
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stdout.replace("\\\n", " ").splitlines()
    return [" ".join(line.split()) for line in lines if " snakemake" in line]


def test_a_run_is_resumed_with_its_options_study_and_target(repository):
    words = (f"OPTIONS=sweep {PROFILE}", "CONFIG=config/sweep.yaml")
    unlock, line = commands(repository, "resume", *words)
    assert f"sweep {PROFILE} --unlock --configfile config/sweep.yaml" in unlock
    # The target stands before --configfile, which would take it for another file.
    expected = f"snakemake sweep {PROFILE} --rerun-incomplete --configfile config/sweep.yaml"
    assert expected in line

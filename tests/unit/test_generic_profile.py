"""The commands by which profiles/generic asks a scheduler, on one that stands in for Slurm."""

import os
import subprocess

import pytest


@pytest.mark.parametrize(
    ("squeue", "state"),
    [
        ("echo RUNNING", "running"),
        ("echo COMPLETED", "success"),
        ("echo TIMEOUT", "failed"),
        ("true", "success"),
        ("echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1", "success"),
        ("echo 'Unable to contact slurm controller' >&2; exit 1", "running"),
    ],
)
def test_a_job_has_ended_only_where_the_scheduler_answers_so(squeue, state, repository, tmp_path):
    command = tmp_path / "squeue"
    command.write_text(f"#!/bin/sh\n{squeue}\n")
    command.chmod(0o755)
    script = repository / "profiles/generic/status.sh"
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    run = subprocess.run(
        ["sh", script, "17"], env={"PATH": path}, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == state

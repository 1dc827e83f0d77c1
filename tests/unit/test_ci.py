"""The stages of .ci/run have the environment of a user, whatever that of a machine is."""

import os
import shutil
import subprocess

import pytest

LEAKING = {"PYTHONUNBUFFERED": "1", "OPENBLAS_NUM_THREADS": "1", "MAKEFLAGS": "-n"}
NEEDED = {"LANG": "C.UTF-8", "PIP_INDEX_URL": "https://example.org", "https_proxy": "proxy"}


@pytest.mark.skipif(not shutil.which("bash"), reason="no bash")
def test_what_a_machine_sets_does_not_reach_the_stages(repository, tmp_path):
    make = tmp_path / "make"  # in place of the true one
    make.write_text('#!/bin/sh\nenv > "$HOME/seen"\n', encoding="utf-8")
    make.chmod(0o755)
    own = {"HOME": str(tmp_path), "PATH": f"{tmp_path}:{os.environ['PATH']}", **NEEDED}
    run = repository / ".ci/run"
    subprocess.run([run], cwd=tmp_path, env={**own, **LEAKING}, check=True)
    seen = (tmp_path / "seen").read_text(encoding="utf-8").splitlines()
    found = dict(line.split("=", 1) for line in seen)
    assert found.items() >= own.items()
    assert found.keys() - own.keys() <= {"PWD", "OLDPWD", "SHLVL", "_"}

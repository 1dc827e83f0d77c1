"""Provenance of a study's results: code, packages, device, configuration."""

import hashlib
import importlib.metadata
import platform
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from squeezefilm import __version__

WORKFLOW_DIR = Path(__file__).resolve().parents[1]
RECORDED_PACKAGES = (
    *("snakemake", "numpy", "scipy", "pandas", "matplotlib", "pyopencl"),
    *("pocl-binary-distribution", "pyarrow", "scikit-fem"),
)


def _library_code_paths(*without: str) -> list[str]:
    """The library's folders and modules but those that are named, and this one."""
    there = sorted(
        path.name for path in WORKFLOW_DIR.glob("squeezefilm/[a-z]*") if path.suffix != ".csv"
    )
    return [f"squeezefilm/{name}" for name in there if name not in ("provenance.py", *without)]


MODEL_CODE_PATHS = _library_code_paths("cli")
SOLVER_CODE_PATHS = [
    *_library_code_paths("cli", "designs", "models"),
    "squeezefilm/designs/space.py",
]
CODE_PATHS_OF_STAGE = {
    "solver": SOLVER_CODE_PATHS,
    "models": MODEL_CODE_PATHS,
    "verification": [*MODEL_CODE_PATHS, "squeezefilm_workflow/verification"],
    "figures": [
        *MODEL_CODE_PATHS,
        "squeezefilm/columns.csv",
        "squeezefilm_workflow/paper",
        "squeezefilm_workflow/reporting",
    ],
}
"""The folders and files, below workflow/, that decide the numbers of a stage, but its scripts."""


def code_digest(stage: str) -> str:
    """A digest of all files in the sources of a stage, with their names.

    Raises FileNotFoundError where a source is not there.
    """
    together = " ".join(map(_source_digest, CODE_PATHS_OF_STAGE[stage]))
    return hashlib.sha256(together.encode()).hexdigest()[:16]


@cache
def _source_digest(source: str) -> str:
    together = hashlib.sha256(source.encode())
    for path in sorted((WORKFLOW_DIR / source).rglob("*.*")) or [WORKFLOW_DIR / source]:
        if path.suffix != ".pyc":
            together.update(str(path.relative_to(WORKFLOW_DIR)).encode() + path.read_bytes())
    return together.hexdigest()


def package_versions() -> dict[str, str]:
    """Versions of the system and of the packages that results depend on."""
    version_of = {
        "squeezefilm": __version__,
        "python": f"{platform.python_version()} ({sys.executable})",
        "system": platform.platform(),
    }
    for name in RECORDED_PACKAGES:
        try:
            version_of[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            version_of[name] = "not installed"
    return version_of


def provenance_record(
    configuration: Mapping[str, Any], *, device: Mapping[str, Any]
) -> dict[str, Any]:
    """The facts, for ``results/STUDY/provenance.json``; without git no commit is known."""
    changed = _git_output("status", "--porcelain", "--", ".", ":!results")
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": _git_output("rev-parse", "HEAD"),
        "changed_since_commit": None if changed is None else changed.splitlines(),
        "code_digests": {stage: code_digest(stage) for stage in CODE_PATHS_OF_STAGE},
        "packages": package_versions(),
        "device": dict(device),
        "configuration": dict(configuration),
    }


def _git_output(*arguments: str) -> str | None:
    if not (WORKFLOW_DIR / "Snakefile").is_file():
        return None  # installed: a repository around it is another one
    try:
        words = ["git", "-C", str(WORKFLOW_DIR.parent), *arguments]
        return subprocess.run(
            words, capture_output=True, text=True, errors="replace", check=True
        ).stdout.rstrip()
    except (OSError, subprocess.CalledProcessError):
        return None

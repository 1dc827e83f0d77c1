"""The conda environments are at the versions that are locked."""

import ast
import re
import sys
from pathlib import Path

import pytest
import yaml

from squeezefilm import __version__

CONDA_NAME = {"matplotlib": "matplotlib-base", "pocl-binary-distribution": "pocl"}
PACKAGES = ("squeezefilm", "squeezefilm_workflow")
DISTRIBUTION = {
    "markdown_it": "markdown-it-py",
    "mpl_toolkits": "matplotlib",
    "pydantic_core": "pydantic",
    "skfem": "scikit-fem",
    "yaml": "pyyaml",
}
NOT_OF_A_JOB = {"pyuff", "snakemake", "xarray"}
"""What universal files of a vibrometer, a script in a debugger and fields of pressure need."""


REPOSITORY = Path(__file__).resolve().parents[2]
WORKFLOW = REPOSITORY / "workflow"
ENVIRONMENT = REPOSITORY / "envs/workflow.yaml"


def third_party(path: Path) -> set[str]:
    """The distributions that a module imports."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(name.name.partition(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module.partition(".")[0])
    names -= set(sys.stdlib_module_names) | set(PACKAGES)
    return {DISTRIBUTION.get(name, name) for name in names}


@pytest.fixture(scope="module")
def locked():
    """Version of each package, by its name on conda-forge; the one for the environments' Python."""
    text = (REPOSITORY / "requirements-dev.lock").read_text(encoding="utf-8")
    pins = re.findall(r"^([a-z0-9-]+)==([^ ;\\]+)(?: ; (.*?))? \\$", text, re.MULTILINE)
    return {
        CONDA_NAME.get(name, name): version
        for name, version, condition in pins
        if ">=" not in condition or "python" not in condition
    }


def test_the_environment_has_the_versions_of_the_lock(locked):
    values = yaml.safe_load(ENVIRONMENT.read_text(encoding="utf-8"))
    pins = dict(line.split(" =") for line in values["dependencies"])
    assert pins.pop("python") == "3.12"
    assert pins == {name: locked[name] for name in pins}
    assert list(pins) == sorted(pins)
    assert values["channels"] == ["conda-forge", "nodefaults"]


def test_the_environment_has_all_that_jobs_import():
    wanted = set().union(*(third_party(path) for path in WORKFLOW.rglob("*.py")))
    text = ENVIRONMENT.read_text(encoding="utf-8")
    missing = {name for name in wanted if f" {CONDA_NAME.get(name, name)} =" not in text}
    assert missing <= NOT_OF_A_JOB


def test_the_citation_is_of_this_version_of_the_software():
    citation = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == __version__
    assert citation["type"] == "software"
    assert citation["date-released"]
    assert "preferred-citation" not in citation  # would be cited in place of the software
    assert any(work["type"] == "article" for work in citation["references"])

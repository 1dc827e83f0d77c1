"""What all tests share."""

import json
import runpy
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config
from squeezefilm.provenance import WORKFLOW_DIR
from squeezefilm.sections import key_of_name
from squeezefilm.studies.study import scene_of_study
from squeezefilm_workflow.mock import mock_snakemake

SHARING_ONE_RUN = tuple(
    f"tests/workflow/test_{name}.py" for name in ("run", "reruns", "pages", "results")
)


@pytest.fixture(scope="session")
def repository():
    """The root of the checkout."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def library_source(repository, tmp_path_factory):
    """A copy of what the wheel is made from: building one leaves files beside it."""
    folder = tmp_path_factory.mktemp("library")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(repository / name, folder / name)
    shutil.copytree(
        repository / "workflow",
        folder / "workflow",
        ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"),
    )
    return folder


@pytest.fixture(scope="session")
def installed(library_source, tmp_path_factory):
    """The wheel's content in a folder, as an installer lays it out."""
    build = "import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])"
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-W", "ignore", "-c", build, str(folder)],
        cwd=library_source,
        check=True,
        capture_output=True,
    )
    (wheel,) = folder.glob("squeezefilm-*.whl")
    site = tmp_path_factory.mktemp("site")
    zipfile.ZipFile(wheel).extractall(site)
    return site


@pytest.fixture(scope="session")
def paper(repository):
    """The paper's study."""
    return load_config(repository / "config" / "paper.yaml")


@pytest.fixture(scope="session")
def quick(repository):
    """The same in small."""
    return load_config(repository / "config" / "quick.yaml")


@pytest.fixture(scope="session")
def scene(paper):
    """The paper's operating point beyond its screen."""
    return scene_of_study(paper, 5e-6, 2.2e-6)


@pytest.fixture(scope="session")
def script() -> Callable[..., None]:
    """A function that runs the script of a rule, without Snakemake, for a study's file."""

    def run(
        name: str,
        config: object,
        *,
        input: dict[str, Any],
        output: object,
        threads: int = 1,
        params: dict[str, Any] | None = None,
        **wildcards: str,
    ) -> None:
        files = output if isinstance(output, dict) else {"file": str(output)}
        job = mock_snakemake(input=input, output=files, params=params, threads=threads, **wildcards)
        module = runpy.run_path(str(WORKFLOW_DIR / "scripts" / f"{name}.py"))
        module["main"](job, load_config(str(config)))

    return run


@pytest.fixture
def refused(capsys):
    """A function that runs a command which must end with a message, and gives the message."""

    def refused(*words: object, status: int = 2) -> str:
        assert main([str(word) for word in words]) == status
        told = capsys.readouterr().err
        assert "squeezefilm: error: " in told
        assert "Traceback" not in told
        return told

    return refused


@pytest.fixture
def edited(repository, tmp_path):
    """A function that writes a study of config/ with other values in its sections."""

    def edited(name: str = "quick", /, **sections: dict[str, Any]) -> Path:
        study = load_config(repository / "config" / f"{name}.yaml")
        written = study.model_dump(exclude_none=True, by_alias=True)
        written |= {key: written[key] | as_written(values) for key, values in sections.items()}
        path = tmp_path / "study.yaml"
        path.write_text(json.dumps(written), encoding="utf-8")  # YAML, without aliases
        return path

    return edited


def as_written(values: Any) -> Any:
    """Sections as a file has them, whose keys have no unit."""
    if isinstance(values, dict):
        return {key_of_name(key): as_written(value) for key, value in values.items()}
    return values


def pytest_collection_modifyitems(items):
    """The longest chain of tests begins first, and next what else starts Snakemake."""

    def late(item: pytest.Item) -> tuple[bool, bool]:
        file = item.nodeid.partition("::")[0]
        return file not in SHARING_ONE_RUN, not file.startswith("tests/workflow/")

    items.sort(key=late)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Files stay whole and in order; those that share a finished run of the workflow are one."""
    from xdist.scheduler import LoadScopeScheduling

    class TogetherScheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return "one run" if file in SHARING_ONE_RUN else file

    config.option.loadscopereorder = False
    return TogetherScheduling(config, log)

"""What all tests share."""

from pathlib import Path
from typing import Any

import pytest

from squeezefilm.io.tables import ScenePoint
from squeezefilm.studies.config import load_config
from squeezefilm.studies.study import scene_of

SHARING_ONE_RUN = ("tests/workflow/test_run.py", "tests/workflow/test_reruns.py")


@pytest.fixture(scope="session")
def repository():
    """The root of the checkout."""
    return Path(__file__).resolve().parents[1]


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
    return scene_of(ScenePoint("1", 5e-6, 2.2e-6, 0.0, 0.0), paper)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Files stay whole, and those that share a finished run of the workflow stay together."""
    from xdist.scheduler import LoadScopeScheduling

    class TogetherScheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return "one run" if file in SHARING_ONE_RUN else file

    return TogetherScheduling(config, log)

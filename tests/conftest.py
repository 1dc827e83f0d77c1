"""What all tests share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

SHARING_ONE_RUN = ("tests/workflow/test_run.py", "tests/workflow/test_reruns.py")


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the checkout."""
    return Path(__file__).resolve().parents[1]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Files stay whole, and those that share a finished run of the workflow stay together."""
    from xdist.scheduler import LoadScopeScheduling

    class TogetherScheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return "one run" if file in SHARING_ONE_RUN else file

    return TogetherScheduling(config, log)

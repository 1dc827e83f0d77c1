"""Every command of the docs that has its place here does what it says, on small studies."""

from pathlib import Path

import pytest

from .commands import to_run
from .conftest import packages_here

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("command", to_run(ROOT), ids=lambda each: f"{each.page}: {each.text}")
def test_a_command_ends_well(outcomes, command):
    outcome = outcomes[command.text]
    assert outcome.status == 0, outcome.told
    assert "Traceback" not in outcome.told


def test_what_is_installed_here_stays_as_it_was(packages_before, outcomes):
    """Commands that install do so in their checkout's environment."""
    assert packages_here() == packages_before

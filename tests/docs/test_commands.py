"""Every command of the docs that has its place here does what it says, on small studies."""

from pathlib import Path

import pytest

from .commands import to_run

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("command", to_run(ROOT), ids=lambda each: f"{each.page}: {each.text}")
def test_a_command_ends_well(outcomes, command):
    outcome = outcomes[command.text]
    assert outcome.status == 0, outcome.told
    assert "Traceback" not in outcome.told

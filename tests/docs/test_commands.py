"""Every command of the docs that has its place here does what it says, on small studies."""

import re
from pathlib import Path

import pytest

from .commands import outputs_on, to_run
from .conftest import packages_here

ROOT = Path(__file__).resolve().parents[2]
WITH_OUTPUT = ("docs/tutorials/your-actuator.md", "docs/how-to/levitate.md")


@pytest.mark.parametrize("command", to_run(ROOT), ids=lambda each: f"{each.page}: {each.text}")
def test_a_command_ends_well(outcomes, command):
    outcome = outcomes[command.text]
    assert outcome.status == 0, outcome.told
    assert "Traceback" not in outcome.told


@pytest.mark.parametrize(
    ("command", "shown"), [each for page in WITH_OUTPUT for each in outputs_on(ROOT / page)]
)
def test_a_page_shows_what_its_command_prints(outcomes, command, shown):
    """Word by word; of a model, which is fitted to a smaller study here, values but no errors."""
    lines = [line.strip() for line in outcomes[command].told.splitlines()]
    printed = dict(re.split("  +", line, maxsplit=1) for line in lines if "  " in line)
    for line in shown:
        label, value = re.split("  +", line, maxsplit=1)
        if "$FIT" not in command:
            assert printed[label] == value
        elif not value.startswith("±"):
            assert re.findall(r"[a-z]+", printed[label]) == re.findall(r"[a-z]+", value)
            numbers = [
                [*map(float, re.findall(r"[\d.]+", text))] for text in (printed[label], value)
            ]
            assert numbers[0] == pytest.approx(numbers[1], rel=0.01)


def test_what_is_installed_here_stays_as_it_was(packages_before, outcomes):
    """Commands that install do so in their checkout's environment."""
    assert packages_here() == packages_before

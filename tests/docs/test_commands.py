"""Every command of the docs that has its place here does what it says, on small studies."""

from pathlib import Path

import pytest

from .commands import missing_lines, shown_on, to_run
from .conftest import packages_here

ROOT = Path(__file__).resolve().parents[2]


def model_values(lines: list[str]) -> dict[str, float]:
    """What a model gives, by the words before it: in a table, the column before the first error."""
    values: dict[str, float] = {}
    column = 0
    for numbered in filter(None, map(str.split, lines)):
        words = numbered[numbered[0].isdigit() :]  # without the number of a row with notes
        errors = [place for place, word in enumerate(words) if "_error_" in f"_{word}"]
        if errors and not column:
            column = errors[0] - 1
        elif column and words[0][0].isdigit():
            values[" ".join(words[:column])] = float(words[column])
        elif words[:2] == ["amplitude", "hv"]:
            values["amplitude hv"] = float(words[2])
    return values


@pytest.mark.parametrize("command", to_run(ROOT), ids=lambda each: f"{each.page}: {each.text}")
def test_a_command_ends_well(outcomes, command):
    outcome = outcomes[command.text]
    assert outcome.status == 0, outcome.told
    assert "Traceback" not in outcome.told


@pytest.mark.parametrize(("command", "shown"), shown_on(ROOT, of_a_study=True))
def test_a_page_shows_what_its_command_prints(outcomes, command, shown):
    """Word by word; of a model, which is fitted to a smaller study here, values but no errors."""
    printed = [" ".join(line.split()) for line in outcomes[command].told.splitlines()]
    if "my-actuator" in command:
        assert missing_lines(shown, printed) == []
        return
    values, expected = model_values(printed), model_values(shown)
    assert expected
    assert {key: values.get(key) for key in expected} == pytest.approx(expected, rel=0.01)


def test_what_is_installed_here_stays_as_it_was(packages_before, outcomes):
    """Commands that install do so in their checkout's environment."""
    assert packages_here() == packages_before

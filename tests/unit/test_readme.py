"""What README and docs type is run, and what they show is what comes out."""

import json
import re
import shlex
from pathlib import Path

import pytest
import yaml

from squeezefilm.cli.main import main
from squeezefilm.formatting import interval_text
from squeezefilm.units import round_up_error

from ..docs.commands import missing_lines, shown_on

ROOT = Path(__file__).resolve().parents[2]
SHOWN = shown_on(ROOT, of_a_study=False)  # of others in tests/docs, on small studies


@pytest.fixture(scope="module")
def readme(repository):
    return (repository / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("command", "shown"), SHOWN, ids=[command for command, _ in SHOWN])
def test_what_a_page_shows_is_what_its_command_prints(command, shown, monkeypatch, capsys):
    """Every line that is shown is printed, to the last digit, but the name of the device."""
    assert len(SHOWN) >= 6
    monkeypatch.chdir(ROOT)
    assert main(shlex.split(command)[1:]) == 0
    printed = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert missing_lines(shown, printed) == []


def test_the_lines_of_python_run(readme, repository, monkeypatch, capsys):
    monkeypatch.chdir(repository)
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert len([line for line in code.splitlines() if line]) <= 10
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    told = capsys.readouterr().out
    assert re.match(r"mean force +0\.95", told)
    assert "error_95_percent" in told
    assert len(names["curve"]) == 9


def test_the_page_on_the_modelling_error_shows_what_the_command_gives(repository, capsys):
    page = (repository / "docs/explanation/modelling-error.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) µm, 2 µm(.*?) \| (.*) \|$", page, re.MULTILINE)
    assert len(rows) == 5
    for h0_um, place, cells in rows:
        x = ["--x", "2.9mm"] if place else []
        assert main(["error-budget", "--h0", f"{h0_um}um", "--hv", "2um", *x, "--json"]) == 0
        budget = json.loads(capsys.readouterr().out)
        names = ("inertia", "thermal", "slip", "edge_loss", "edge_loss_upper", "edge_flow")
        numbers = [budget[f"{name}_percent"] for name in names]
        error = round_up_error(budget["edge_flow_error_percent"])
        ends = (budget[f"modelling_error_{end}_percent"] for end in ("lower", "upper"))
        shown = [text.replace("−", "-") for text in re.findall(r"[+−][\d.]+", cells)]
        assert shown == [
            *(f"{number:+#.2g}".rstrip(".") for number in numbers),
            *interval_text(*ends).split(" to "),
        ]
        assert re.findall(r"± ([\d.]+)", cells) == [f"{error:#.2g}".rstrip(".")]


def test_the_citation_is_of_this_version_of_the_software(repository, capsys):
    citation = yaml.safe_load((repository / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (repository / "CHANGELOG.md").read_text(encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["--version"])
    version = capsys.readouterr().out.split()[-1]
    assert (citation["type"], citation["version"]) == ("software", version)
    assert "preferred-citation" not in citation
    released = citation["date-released"]
    assert f"## {version} – {released.day} {released:%B %Y}" in changes
    assert citation["references"][0]["doi"] == "10.1109/TIA.2013.2288415"

"""What the README types is run, and what it shows is what comes out."""

import json
import re
import shlex

import pytest
import yaml

from squeezefilm.cli.main import main


@pytest.fixture(scope="module")
def readme(repository):
    return (repository / "README.md").read_text(encoding="utf-8")


def test_the_force_is_the_one_that_is_shown(readme, capsys):
    command, *shown = re.findall(r"^    (.*)$", readme.partition("## One force")[2], re.MULTILINE)
    assert main(shlex.split(command.removeprefix("$ squeezefilm "))) == 0
    lines = capsys.readouterr().out.splitlines()
    (device,) = [place for place, line in enumerate(lines) if line.startswith("device ")]
    assert [line for place, line in enumerate(lines) if place != device] == [
        line for place, line in enumerate(shown[: len(lines)]) if place != device
    ]


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
        names = ("inertia", "thermal", "slip", "edge_loss", "edge_loss_upper")
        names += ("modelling_error_lower", "modelling_error_upper")
        shown = [float(text.replace("−", "-")) for text in re.findall(r"[+−][\d.]+", cells)]
        assert shown == pytest.approx([budget[f"{name}_percent"] for name in names], rel=0.05)


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

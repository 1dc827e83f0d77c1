"""What the README types is run, and what it shows is what comes out."""

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
    # The third line is about the device.
    for place in (0, 1, 3):
        assert lines[place] == shown[place]
    assert lines[2].partition(" on ")[0] == "periodic"


def test_the_lines_of_python_run(readme, repository, monkeypatch, capsys):
    monkeypatch.chdir(repository)
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert len([line for line in code.splitlines() if line]) <= 10
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    told = capsys.readouterr().out
    assert told.startswith("force 0.95")
    assert "error_95_percent" in told
    assert len(names["curve"]) == 9


@pytest.mark.parametrize("page", ["README.md", "docs/cluster.md"])
def test_a_profile_stands_after_the_plugin_that_it_needs(repository, page):
    text = (repository / page).read_text(encoding="utf-8")
    (at, *_) = [match.start() for match in re.finditer("--workflow-profile profiles/slurm", text)]
    profile = yaml.safe_load((repository / "profiles/slurm/config.yaml").read_text("utf-8"))
    assert f"pip install snakemake-executor-plugin-{profile['executor']}\n" in text[:at]


def test_the_readme_counts_the_films_that_the_solver_s_page_has(readme, repository):
    page = (repository / "docs/solver.md").read_text(encoding="utf-8")
    table = page.partition("### Are forces as good as they say?")[2].partition("\n### ")[0]
    counts = [int(count) for count in re.findall(r"\| 0 of (\d+) \|", table)]
    of_any_gap = table[: table.index("| tilted, crowned")].count("| 0 of ")
    plain, any_gap = sum(counts[:of_any_gap]), sum(counts[of_any_gap:])
    assert f"Of {plain} random films" in readme
    assert f"and {any_gap} that are tilted" in readme

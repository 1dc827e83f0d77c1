"""No command of the docs is without a place: run here, in another stage, or said to be in none."""

import re
from pathlib import Path

import pytest

from squeezefilm.cli.main import modules_by_command
from squeezefilm_workflow.paper.figures import FIGURES as PAPER_FIGURES
from squeezefilm_workflow.reporting.figures import FIGURES
from squeezefilm_workflow.verification.__main__ import COMMAND_GROUPS as VERIFICATION

from .commands import BY_HAND, ELSEWHERE, NAMES, SMALLER, all_commands, stages, to_run


@pytest.fixture(scope="module")
def texts(repository):
    return [command.text for command in all_commands(repository)]


def test_the_docs_have_commands_and_each_has_one_place(repository, texts):
    run = {command.text for command in to_run(repository)}
    assert len(run) > 50
    for text in texts:
        tests = text.startswith("pytest ") or text in stages(repository)
        named = any(pattern.fullmatch(text) for pattern in NAMES.values()) and text not in run
        places = [run, ELSEWHERE, BY_HAND]
        assert sum(text in place for place in places) + tests + named == 1, text


def test_what_is_said_of_a_command_is_said_of_one_that_is_there(repository, texts):
    for table in (SMALLER, ELSEWHERE, BY_HAND):
        assert set(table) <= set(texts)
    assert {"make test-docs", *ELSEWHERE.values()} <= set(stages(repository))
    for text in texts:
        if text.startswith("pytest "):
            assert (repository / text.split()[1]).is_file(), text


def test_what_is_named_is_there(repository, texts):
    rules = "".join(path.read_text("utf-8") for path in repository.glob("workflow/rules/*.smk"))
    rules += (repository / "workflow/Snakefile").read_text(encoding="utf-8")
    targets = {*re.findall(r"^ *(?:rule|checkpoint) (\w+):", rules, re.MULTILINE)}
    figures = {Path(place).name for place in (*FIGURES, *PAPER_FIGURES)}
    known = {
        "squeezefilm": modules_by_command(),
        "verification": modules_by_command(VERIFICATION),
        "snakemake": targets | figures,
    }
    for text in texts:
        for name, pattern in NAMES.items():
            match = pattern.fullmatch(text)
            for word in match[1].split() if match else ():
                assert word in known[name], text

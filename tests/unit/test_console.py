"""What a run of the workflow says: a line for each job, where to look at the end."""

import json
import logging

import pytest

from squeezefilm.io.tables import write_json
from squeezefilm.runs import console


@pytest.fixture
def said():
    """A logger as Snakemake's, and the lines on its terminal."""
    lines = []

    class Terminal(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            lines.append(self.format(record))

    logger = logging.Logger("snakemake of a test")
    terminal, file = Terminal(), logging.NullHandler()
    terminal.name = console.CONSOLE
    logger.handlers = [terminal, file]
    console.quieten(logger, about="Study mine", pace_s=2.0)
    assert file.formatter is None
    assert not file.filters
    return logger, lines


def job(number: int, message: str | None) -> dict[str, object]:
    return {"event": "job_info", "jobid": number, "rule_msg": message, "reason": "it is missing"}


def test_a_job_is_a_line_without_its_reason(said):
    logger, lines = said
    logger.info("Building DAG of jobs...")
    logger.info("Job stats: a table", extra={"event": "run_info", "stats": {"fit": 2, "total": 60}})
    logger.info("Rule: fit", extra=job(7, "Fit the model"))
    logger.info("Finished jobid: 7", extra={"event": "job_finished"})
    logger.info(None, extra={"event": "progress", "done": 1, "total": 60})
    logger.info("Rule: plan", extra=job(3, "Points to simulate"))
    logger.info(None, extra={"event": "progress", "done": 60, "total": 60})
    assert lines[0] == "Study mine: 60 jobs; about 2 min if each takes 2 s, as in earlier runs here"
    assert [line[10:] for line in lines[1:3]] == [
        " 1/60  Fit the model",
        " 2/60  Points to simulate",
    ]
    assert len(lines) == 4


def test_what_goes_wrong_is_said_in_full(said):
    logger, lines = said
    logger.error("Error in rule fit: no force", extra={"event": "job_error"})
    logger.info("Error in rule fit: log", extra={"event": "job_error"})
    logger.warning("Select jobs carefully")
    logger.info("Nothing to be done")
    logger.info("Job 3 has been submitted")
    assert len(lines) == 5


def test_the_pace_is_that_of_long_runs_that_were_completed_here(tmp_path):
    def card(name: str, **changes: object) -> None:
        path = tmp_path / "mine" / "run_cards" / f"{name}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        values = {
            "outcome": "completed",
            "hosts": ["here"],
            "started": "2026-01-01T00:00:00+00:00",
            "ended": "2026-01-01T00:01:00+00:00",
            "jobs": [{}] * 20,
        }
        path.write_text(json.dumps(values | changes), encoding="utf-8")

    assert console.pace(tmp_path, host="here") is None
    card("a")
    card("b", outcome="killed", jobs=[{}] * 200)
    card("c", hosts=["there"], jobs=[{}] * 200)
    card("d", jobs=[{}] * 2)
    card("e", started="once")
    assert console.pace(tmp_path, host="here") == 3.0


def test_a_run_ends_with_its_numbers_and_where_they_lie(study, tmp_path):
    assert console.where_to_look(tmp_path) == []
    lines = console.where_to_look(study.root)
    assert lines[0] == "F(h0 = 5 µm, hv = 2.2 µm, finger centred) = 0.9620420 N ± 2e-07 N"
    assert "fitted to 5 points is" in lines[1]
    (tmp_path / "explorer.html").touch()
    (tmp_path / "claims.csv").write_text("verdict\nagrees exactly\ndiffers because\n")
    write_json({"point": "no number"}, tmp_path / "fits" / "two_factor_design.json")
    assert console.where_to_look(tmp_path) == [
        "1 of 2 claims of the paper agree",
        f"{tmp_path}/explorer.html: a page to play with, no network needed",
    ]

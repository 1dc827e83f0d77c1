"""What a run of the workflow says to people: a line for each job, and at the end where to look.

Snakemake's log file, in .snakemake/log, keeps all that is left out here.
"""

import csv
import logging
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from squeezefilm.io.job import remembered
from squeezefilm.io.typed_units import with_error

CONSOLE = "DefaultStreamHandler"
"""Snakemake's name for its handler of the terminal."""
UNSAID = {"workflow_started", "resources_info", "job_started", "job_finished"}
"""Events of Snakemake that are left out; others, such as errors, are shown as they are."""
BOILERPLATE = (
    "Assuming unrestricted",
    "Building DAG",
    "Complete log",
    "Conda environments",
    "Select jobs",
    "Using shell",
)
LEAST_JOBS = 10
"""Runs of fewer jobs say little about how long others take."""
COMPLETED = "completed"


class OneLine(logging.Formatter):
    """A line for each job of a run, by the message of its rule."""

    def __init__(self, usual: logging.Formatter | None, *, about: str, pace_s: float | None):
        """Args: usual: formatter of all else; about: the run in words; pace_s: time of a job."""
        super().__init__()
        self.usual = usual or logging.Formatter()
        self.about, self.pace_s = about, pace_s
        self.total = 0
        self.begun: set[object] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether anything is said of an event."""
        if record.levelno > logging.INFO:
            return True
        event = _event(record)
        if event == "progress":  # the last one alone
            return bool(getattr(record, "done", 0) == getattr(record, "total", 1))
        return event not in UNSAID and not str(record.msg).startswith(BOILERPLATE)

    def format(self, record: logging.LogRecord) -> str:
        event, message = _event(record), getattr(record, "rule_msg", None)
        if event == "run_info":
            self.total = int(getattr(record, "stats", {}).get("total", 0))
            return f"{self.about}: {self.total} jobs{self._time()}"
        if event == "job_info" and message:
            self.begun.add(getattr(record, "jobid", len(self.begun)))
            at = datetime.fromtimestamp(record.created).strftime("%H:%M:%S")
            width = len(str(self.total))
            return f"{at}  {len(self.begun):{width}}/{self.total}  {message}"
        return self.usual.format(record)

    def _time(self) -> str:
        if self.pace_s is None:
            return "; no earlier run tells how long that takes here"
        seconds = self.total * self.pace_s
        said = f"{seconds / 60:.0f} min" if seconds > 100 else f"{max(seconds, 1):.0f} s"
        return f"; about {said} if each takes {self.pace_s:.1g} s, as in earlier runs here"


def quieten(logger: logging.Logger, *, about: str, pace_s: float | None) -> None:
    """Let Snakemake's terminal have a line for each job; its log file stays as it is."""
    for handler in logger.handlers:
        if handler.name == CONSOLE:
            one_line = OneLine(handler.formatter, about=about, pace_s=pace_s)
            handler.setFormatter(one_line)
            handler.addFilter(one_line)


def pace(results: Path, *, host: str) -> float | None:
    """Seconds that a job took on average in completed runs on a host; None where there are none.

    Args:
        results: the folder of all studies' results, whose run cards are read.
    """
    seconds, jobs = 0.0, 0
    for path in results.glob("*/run_cards/*.json"):
        card = remembered(path)
        done = card.get("jobs", [])
        if card.get("outcome") == COMPLETED and card.get("hosts") == [host]:
            with suppress(KeyError, TypeError, ValueError):
                start, end = (datetime.fromisoformat(card[key]) for key in ("started", "ended"))
                if len(done) >= LEAST_JOBS:
                    seconds += (end - start).total_seconds()
                    jobs += len(done)
    return seconds / jobs if jobs else None


def headline(results: Path) -> list[str]:
    """A finished study's headline numbers, as far as they are there."""
    return [*_force(results), *_model(results), *_claims(results)]


def where_to_look(results: Path) -> list[str]:
    """A finished study's headline numbers and the files to open first, as far as they are there."""
    lines = headline(results)
    for name, what in (
        ("report/summary.html", "the study on one page"),
        ("report/claims.html", "the paper's claims beside ours"),
        ("figures", "the figures, each with its table"),
        ("explorer.html", "a page to play with, no network needed"),
    ):
        if (results / name).exists():
            lines.append(f"{results / name}: {what}")
    return lines


def _force(results: Path) -> Iterator[str]:
    for row in _rows(results / "simulations" / "extrapolation" / "forces.csv"):
        if row.get("point_id") == "operating_point" and row.get("status") == "ok":
            force = with_error(float(row["force_n"]), float(row["force_error_n"]))
            h0, hv = (1e6 * float(row[name]) for name in ("h0_m", "hv_m"))
            scan = remembered(results / "profile" / "summary.json")
            noise = scan.get("largest_force_noise_share")
            more = (
                f", the solver's error; the scan's noise: up to {noise:.1%} more" if noise else ""
            )
            yield f"F(h0 = {h0:g} µm, hv = {hv:g} µm, finger centred) = {force}{more}"


def _model(results: Path) -> Iterator[str]:
    summary = remembered(results / "validation" / "two_factor_design_on_screen.json")
    design = remembered(results / "fits" / "two_factor_design.json")
    with suppress(KeyError, TypeError):
        yield (
            f"the model fitted to {design['points']:.0f} points is "
            f"{100 * summary['global_error']:.2g} % off over the {summary['points']:.0f} points "
            "of the screen"
        )


def _claims(results: Path) -> Iterator[str]:
    verdicts = [row.get("verdict", "") for row in _rows(results / "claims.csv")]
    if verdicts:
        agreeing = sum(verdict.startswith("agrees") for verdict in verdicts)
        yield f"{agreeing} of {len(verdicts)} claims of the paper agree"


def _rows(path: Path) -> list[dict[str, str]]:
    """The rows of a table; none where it is missing or damaged."""
    with suppress(OSError, UnicodeDecodeError, csv.Error), path.open(encoding="utf-8") as handle:
        return list(csv.DictReader(handle))
    return []


def _event(record: logging.LogRecord) -> str:
    event = getattr(record, "event", None)
    return str(getattr(event, "value", event))

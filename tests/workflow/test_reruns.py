"""An edit makes anew exactly what depends on it.

What depends on it is found apart from the workflow's own way of finding it: from what each job's
process loaded, opened and read while the quick study ran (tracing/), completed by the standard
library's modulefinder, which reads byte code, with the modules that a job might load another time.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from functools import cache
from modulefinder import ModuleFinder
from pathlib import Path
from types import CodeType
from typing import Any

import pytest
import yaml

from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import SCHEMA_PATH, load_config
from squeezefilm.studies.study import check_study

from .conftest import EVERYTHING, Finished, Planner, Trace

WORKFLOW = Path("workflow")
LIBRARY = WORKFLOW / "squeezefilm"
PACKAGES = ("squeezefilm", "numerics", "reporting", "paper")
REPOSITORY = Path(__file__).resolve().parents[2]
CODE = sorted(
    path.relative_to(REPOSITORY)
    for folder in (REPOSITORY / WORKFLOW / name for name in (*PACKAGES, "schemas"))
    for path in folder.rglob("*")
    if path.is_file() and path.suffix != ".pyc"
)


@dataclass(frozen=True)
class Job:
    """A job of the finished run: what it wrote, what it had as input, what its process used."""

    rule: str
    outputs: frozenset[str]
    inputs: frozenset[str]
    trace: Trace
    code: frozenset[Path]


@cache
def imported_by(module: Path, checkout: Path) -> frozenset[Path]:
    """The files that a module can load: modules by modulefinder, and data that their code names."""
    finder = ModuleFinder(path=[str(checkout / "workflow")])
    finder.load_file(str(checkout / module))
    modules = [found for found in finder.modules.values() if found.__file__]
    names = set().union(*(texts_in(found.__code__) for found in modules if found.__code__))
    data = {path for path in CODE if path.suffix != ".py" and path.name in names}
    while more := {path for path in CODE if path.name in includes_of(data, checkout)} - data:
        data |= more
    return frozenset(data.union(Path(found.__file__).relative_to(checkout) for found in modules))


def texts_in(constant: Any) -> set[str]:
    """The texts among the constants of compiled code, at any depth."""
    if isinstance(constant, str):
        return {constant}
    if isinstance(constant, CodeType):
        constant = constant.co_consts
    return set().union(*map(texts_in, constant)) if isinstance(constant, tuple) else set()


def includes_of(kernels: set[Path], checkout: Path) -> set[str]:
    """The names of the files that kernels include."""
    lines = (line for path in kernels for line in (checkout / path).read_text().splitlines())
    return {line.split('"')[1] for line in lines if line.startswith('#include "')}


@pytest.fixture(scope="session")
def jobs(finished: Finished, planner: Planner) -> list[Job]:
    """Every job, told by the command it ran."""
    by_command: dict[str, list[dict[str, str]]] = {}
    for row in planner.rows(*EVERYTHING):
        if row["shellcmd"].strip() not in ("", "-"):
            by_command.setdefault(row["shellcmd"], []).append(row)
    traces = {" ".join(trace.arguments): trace for trace in finished.traces}
    found = []
    for command, rows in by_command.items():
        words = " ".join(re.split(r"python -m \w+ ", command)[1].split(" >")[0].split())
        trace = traces[words]
        may_load = (imported_by(module, finished.folder) for module in trace.modules)
        found.append(
            Job(
                rule=rows[0]["rule"],
                outputs=frozenset(row["output_file"] for row in rows),
                inputs=frozenset(rows[0]["input-file(s)"].split(",")),
                trace=trace,
                code=trace.files.union(*may_load),
            )
        )
    assert len(found) == len(traces) > 40
    return found


def with_dependents(first: set[str], jobs: list[Job]) -> set[str]:
    """Files, and all that are made from them."""
    reached = set(first)
    while True:
        more = {
            output for job in jobs for output in job.outputs if not reached.isdisjoint(job.inputs)
        }
        if more <= reached:
            return reached
        reached |= more


def test_all_that_a_job_uses_is_among_its_inputs(jobs: list[Job]) -> None:
    for job in jobs:
        used = {str(path) for path in job.trace.files}
        assert used <= job.inputs, (job.outputs, used - job.inputs)


def test_every_solver_file_is_in_use(jobs: list[Job]) -> None:
    used = set().union(*(job.code for job in jobs))
    for name in (
        "reynolds/periodic.cl",
        "reynolds/periodic.py",
        "models/fit.py",
        "designs/paper_design.py",
    ):
        assert LIBRARY / name in used


def edited(path: Path, folder: Path) -> str:
    mark = {".py": "\nEDITED = True\n", ".cl": "\n#define EDITED 1\n"}.get(path.suffix, "\n# new\n")
    return (folder / path).read_text(encoding="utf-8") + mark


def fours(paths: list[Path]) -> list[tuple[Path, ...]]:
    """Four files at a time, from places far apart in the list."""
    count = -(-len(paths) // 4)
    return [tuple(paths[start::count]) for start in range(count)]


# Most edits reach few jobs. Files that reach most jobs are asked together, so as to hide no other.
EVERYWHERE = {LIBRARY, LIBRARY / "runs", LIBRARY / "studies"}
GROUPS = [
    *fours([path for path in CODE if path.parent in EVERYWHERE]),
    *fours([path for path in CODE if path.parent not in EVERYWHERE]),
]


@pytest.mark.parametrize("paths", GROUPS, ids=lambda paths: " ".join(map(str, paths)))
def test_an_edit_of_the_code_makes_anew_what_it_reaches(
    paths: tuple[Path, ...], jobs: list[Job], planner: Planner
) -> None:
    edits = {path: edited(path, planner.folder) for path in paths}
    reached = {o for job in jobs if not job.code.isdisjoint(edits) for o in job.outputs}
    expected = with_dependents(reached, jobs)
    assert planner.made_anew(*EVERYTHING, edits=edits) == expected


def leaves(values: dict[str, Any], place: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The keys of a study that commands read; a profile is one, its keys belong together."""
    for key, value in values.items():
        if isinstance(value, dict) and key not in ("profile", "models"):
            yield from leaves(value, (*place, key))
        elif key not in ("study", "seconds_per_job"):
            yield (*place, key)


def words_of(schema: Any) -> Iterator[str]:
    """All words that some key may have."""
    if isinstance(schema, dict):
        yield from schema.get("enum", [])
        for part in schema.values():
            yield from words_of(part)


WORDS = sorted(set(words_of(yaml.safe_load(SCHEMA_PATH.read_text(encoding="utf-8")))))
STUDY = yaml.safe_load((REPOSITORY / "config/quick.yaml").read_text(encoding="utf-8"))


def others(value: Any) -> Iterator[Any]:
    """Values to try instead of one."""
    if isinstance(value, dict):
        yield {"kind": "piston"}
        yield {**value, "another": deepcopy(next(iter(value.values())))}
    elif isinstance(value, bool):
        yield not value
    elif isinstance(value, list):
        yield value[:-1]
        yield [*value, 7]
    elif isinstance(value, int | float) or value[:1].isdigit():
        number = float(value) if isinstance(value, str) else value
        yield from (number * 1.001, number * 0.999, number + 1, number - 1, 1e-3, 1e-7)
    else:
        yield from (*WORDS, "pocl")


def is_number(place: tuple[str, ...]) -> bool:
    value: Any = STUDY
    for key in place:
        value = value[key]
    return isinstance(value, int | float) or (isinstance(value, str) and value[:1].isdigit())


# One key of each section, a number if it has one: a rule has whole sections among its params.
PLACES = {place[0]: place for place in sorted(leaves(STUDY), key=is_number)}.values()


@pytest.mark.parametrize("place", PLACES, ids=".".join)
def test_an_edit_of_the_study_makes_anew_what_reads_its_section(
    place: tuple[str, ...], jobs: list[Job], planner: Planner, tmp_path: Path
) -> None:
    text = edited_study(planner.folder / "config/quick.yaml", place, tmp_path)
    made = planner.made_anew(*EVERYTHING, edits={Path("config/quick.yaml"): text})
    read = {o for job in jobs if place[0] in job.trace.sections for o in job.outputs}
    assert undivided(made) == undivided(with_dependents(read, jobs))


def undivided(names: set[str]) -> set[str]:
    """Files by name, but for the chunk: an edit may change how many there are."""
    return {re.sub(r"/\d+-of-\d+\.", "/", name) for name in names}


def test_jobs_of_another_length_make_anew_what_is_divided_otherwise(
    jobs: list[Job], planner: Planner
) -> None:
    config = Path("config/quick.yaml")
    text = (planner.folder / config).read_text(encoding="utf-8")
    shorter = re.sub(r"(seconds_per_job:) \S+", r"\1 0.006", text)
    made = planner.made_anew(*EVERYTHING, edits={config: shorter})
    chunks = {name for name in made if "/chunks/" in name}
    plans = {Path(name).parts[3] for name in chunks}
    assert {"four_factor", "sweep"} <= plans
    assert "screen" not in plans
    gathered = {
        output
        for job in jobs
        for output in job.outputs
        if job.rule.startswith("gather") and Path(output).parts[3] in plans
    }
    expected = {name for name in with_dependents(gathered, jobs) if "/chunks/" not in name}
    assert made - chunks == expected


def edited_study(path: Path, place: tuple[str, ...], folder: Path) -> str:
    """The study with another valid value at one place."""
    value: Any = load_config(path)
    for key in place:
        value = value[key]
    for other in others(value):
        study = dict(load_config(path))
        section = study
        for key in place[:-1]:
            section[key] = section = dict(section[key])
        section[place[-1]] = other
        if other == value:
            continue
        text = yaml.safe_dump(study)
        (folder / "study.yaml").write_text(text, encoding="utf-8")
        try:
            check_study(load_config(folder / "study.yaml"))
        except InputError:
            continue
        return text
    pytest.fail(f"no other valid value for {'.'.join(place)}")


def test_after_all_edits_are_undone_nothing_is_made_anew(planner: Planner) -> None:
    for path in [*CODE, Path("config/quick.yaml")]:
        file = planner.folder / path
        file.write_bytes(file.read_bytes())  # the same text, a new time
    assert planner.made_anew(*EVERYTHING) == set()

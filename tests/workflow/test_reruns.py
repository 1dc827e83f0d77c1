"""An edit makes anew exactly what depends on it, and one that changes no result makes nothing anew.

What depends on it is found apart from the workflow's own way of finding it: from what each job's
process loaded, opened and read while the quick study ran (tracing/), completed by the standard
library's modulefinder, which reads byte code, with the modules that a job might load another time.
This is compared with what each job has as its basis (runs/basis.py); that Snakemake plans by it is
seen in a few dry runs.
"""

import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import cache
from modulefinder import ModuleFinder
from pathlib import Path
from types import CodeType
from typing import Any

import pytest
import yaml

from squeezefilm.runs.code import DECIDES_NOTHING

from .conftest import (
    EVERYTHING,
    QUICK,
    Trace,
    copy_checkout,
    snakemake,
)

WORKFLOW = Path("workflow")
LIBRARY = WORKFLOW / "squeezefilm"
PACKAGES = ("squeezefilm", "verification", "reporting", "paper")
REPOSITORY = Path(__file__).resolve().parents[2]
CODE = sorted(
    path.relative_to(REPOSITORY)
    for folder in (REPOSITORY / WORKFLOW / name for name in PACKAGES)
    for path in folder.rglob("*")
    if path.is_file() and path.suffix != ".pyc"
)
IDLE = {path for path in CODE for place in DECIDES_NOTHING if path.match(f"workflow/{place}")}
# The packages around them and around commands, which are loaded with them, have a docstring and
# nothing else.
PACKAGES_OF_COMMANDS = ("workflow/squeezefilm/cli/*/__init__.py", "workflow/*/commands/__init__.py")
AROUND = {folder / "__init__.py" for path in IDLE for folder in path.parents} - IDLE
AROUND |= {path for path in CODE for place in PACKAGES_OF_COMMANDS if path.match(place)}


@dataclass(frozen=True)
class Job:
    """A job of the finished run: what it wrote, what it had as input, what its process used.

    ``basis`` is what its basis lists: files by their path, sections by their name.
    """

    rule: str
    outputs: frozenset[str]
    inputs: frozenset[str]
    trace: Trace
    code: frozenset[Path]
    basis: frozenset[str]


class Direct(ModuleFinder):
    """Follows what one file imports, and not what is imported there."""

    def __init__(self, file: Path, checkout: Path) -> None:
        super().__init__(path=[str(checkout / "workflow")])
        self.file = str(file)
        self.load_file(self.file)

    def scan_code(self, co: CodeType, m: Any) -> None:
        if m.__file__ == self.file:
            super().scan_code(co, m)


@cache
def loads(path: Path, checkout: Path) -> frozenset[Path]:
    """The files that a file loads itself: modules by modulefinder, and data that its code names."""
    if path.suffix != ".py":
        return frozenset(each for each in CODE if each.name in includes_of(path, checkout))
    modules = [each for each in Direct(checkout / path, checkout).modules.values() if each.__file__]
    texts = texts_in(modules[0].__code__)
    names = {text.rpartition("/")[2] for text in texts}
    data = {each for each in CODE if each.suffix != ".py" and each.name in names}
    if path not in IDLE and "modules_in(" in (checkout / path).read_text(encoding="utf-8"):
        packages = {WORKFLOW.joinpath(*text.split(".")) for text in texts if "." in text}
        data |= {each for each in CODE if each.suffix == ".py" and each.parent in packages}
    return frozenset(data.union(Path(each.__file__).relative_to(checkout) for each in modules))


def imported_by(module: Path, checkout: Path) -> set[Path]:
    """The files that a module can load, at any depth."""
    reached, waiting = set(), {module}
    while waiting:
        reached |= waiting
        waiting = set().union(*(loads(path, checkout) for path in waiting)) - reached
    return reached


def texts_in(constant: Any) -> set[str]:
    """The texts among the constants of compiled code, at any depth."""
    if isinstance(constant, str):
        return {constant}
    if isinstance(constant, CodeType):
        constant = constant.co_consts
    return set().union(*map(texts_in, constant)) if isinstance(constant, tuple) else set()


def includes_of(kernel: Path, checkout: Path) -> set[str]:
    """The names of the files that a kernel includes."""
    lines = (checkout / kernel).read_text(encoding="utf-8").splitlines()
    return {line.split('"')[1] for line in lines if line.startswith('#include "')}


@pytest.fixture(scope="session")
def jobs(finished, planner):
    """Every job, told by the command it ran."""
    by_command: dict[str, list[dict[str, str]]] = {}
    for row in planner.rows(*EVERYTHING):
        if row["shellcmd"].strip() not in ("", "-"):
            by_command.setdefault(row["shellcmd"], []).append(row)
    traces = {" ".join(trace.arguments): trace for trace in finished.traces}
    found = []
    frame = frozenset.intersection(*(trace.modules for trace in finished.traces)) | IDLE | AROUND
    for command, rows in by_command.items():
        words = " ".join(re.split(r"python -m \w+ ", command)[1].split(" >")[0].split())
        trace = traces[words]
        may_load = (imported_by(module, finished.folder) for module in trace.modules - frame)
        inputs = rows[0]["input-file(s)"].split(",")
        listed = (finished.folder / name for name in inputs if "/basis/" in name)
        found.append(
            Job(
                rule=rows[0]["rule"],
                outputs=frozenset(row["output_file"] for row in rows),
                inputs=frozenset(inputs),
                trace=trace,
                code=(trace.files - frame).union(*may_load) - IDLE - AROUND,
                basis=frozenset(
                    line.split(" ")[0] for path in listed for line in path.read_text().splitlines()
                ),
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


def test_all_that_a_job_uses_is_its_basis_and_nothing_else(jobs):
    for job in jobs:
        listed = {WORKFLOW / name for name in job.basis if "/" in name} - AROUND
        assert listed == job.code, (job.outputs, listed ^ job.code)


def edited(path: Path, folder: Path) -> str:
    mark = {".py": "\nEDITED = True\n", ".cl": "\n#define EDITED 1\n"}.get(path.suffix, "\n# new\n")
    return (folder / path).read_text(encoding="utf-8") + mark


@pytest.mark.parametrize(
    "name",
    [
        "reynolds/periodic/periodic.cl",
        "models/fitting/fit.py",
        "models/models.yaml",
        "io/tables.py",
    ],
)
def test_an_edit_of_the_code_makes_anew_what_it_reaches(name, jobs, planner):
    path = LIBRARY / name
    reached = {output for job in jobs if path in job.code for output in job.outputs}
    made = planner.made_anew(*EVERYTHING, edits={path: edited(path, planner.folder)})
    assert made == with_dependents(reached, jobs)
    assert made


def test_an_edit_of_what_only_people_read_makes_nothing_anew(planner):
    """A comment in every file, docstrings, help texts; and what decides nothing, in earnest.

    But for the docstrings of figures and tables: those are captions, which the report shows.
    """
    edits = {}
    for path in CODE:
        text = (planner.folder / path).read_text(encoding="utf-8")
        if path in IDLE:
            edits[path] = edited(path, planner.folder)
        elif path.suffix == ".py":
            if path.parent.name not in ("figures", "tables"):
                text = re.sub(r'^"""', '"""Edited: ', text)
            edits[path] = text.replace(' help="', ' help="edited: ')
            edits[path] += "# edited\n"
        elif path.suffix == ".cl":
            edits[path] = f"// edited\n{text}"
    schema = LIBRARY / "studies/config.schema.yaml"
    edits[schema] = re.sub(r"description: (?=\w)", "description: Edited ", edits[schema])
    assert planner.made_anew(*EVERYTHING, edits=edits) == set()


STUDY = yaml.safe_load((REPOSITORY / "config/quick.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("section", sorted(STUDY.keys() - {"study", "simulation"}))
def test_what_reads_a_section_of_the_study_has_it_as_its_basis(section, jobs):
    read = {o for job in jobs if section in job.trace.sections for o in job.outputs}
    listed = {o for job in jobs if section in job.basis for o in job.outputs}
    assert with_dependents(listed, jobs) == with_dependents(read, jobs)


@pytest.mark.parametrize(
    ("section", "old", "new"),
    [
        ("gas", "1.81e-5", "1.82e-5"),
        ("positions", "[0.002, 0.0029]", "[0.001, 0.0029]"),
        ("fit", "bounds: [100]", "bounds: [90]"),
        ("validation", "relative_error_band: 0.15", "relative_error_band: 0.16"),
    ],
)
def test_an_edit_of_the_study_makes_anew_what_reads_its_section(section, old, new, jobs, planner):
    text = (planner.folder / "config/quick.yaml").read_text(encoding="utf-8")
    assert text.count(old) == 1
    edits = {Path("config/quick.yaml"): text.replace(old, new)}
    made = planner.made_anew(*EVERYTHING, edits=edits)
    read = {o for job in jobs if section in job.trace.sections for o in job.outputs}
    assert undivided(made) == undivided(with_dependents(read, jobs))


def undivided(names: set[str]) -> set[str]:
    """Files by name, but for the chunk: an edit may change how many there are."""
    return {re.sub(r"/\d+-of-\d+\.", "/", name) for name in names}


def test_jobs_of_another_length_make_anew_what_is_divided_otherwise(jobs, planner):
    config = Path("config/quick.yaml")
    text = (planner.folder / config).read_text(encoding="utf-8")
    shorter = re.sub(r"(seconds_per_job:) \S+", r"\1 0.004", text)
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


def test_after_all_edits_are_undone_nothing_is_made_anew(planner):
    for path in [*CODE, Path("config/quick.yaml")]:
        file = planner.folder / path
        file.write_bytes(file.read_bytes())  # the same text, a new time
    assert planner.made_anew(*EVERYTHING) == set()


NOTHING = "Nothing to be done"
SCENES = "results/quick/simulations/screen/scenes.csv"
KERNEL = LIBRARY / "reynolds/periodic/periodic.cl"


def test_results_copied_to_a_clone_are_as_they_were_until_its_code_is_edited(finished, tmp_path):
    """Without Snakemake's records there are the files' times alone."""
    clone = copy_checkout(finished.folder, tmp_path / "clone")
    shutil.copytree(finished.folder / "results", clone / "results")  # with their times
    assert NOTHING in snakemake(clone, *EVERYTHING, "--dry-run", *QUICK).stdout
    before = (clone / KERNEL).read_text(encoding="utf-8")
    (clone / KERNEL).write_text(edited(KERNEL, clone), encoding="utf-8")
    done = snakemake(clone, "two_factor", "--dry-run", *QUICK)
    assert "Simulate screen, part 1 of 1" in done.stdout
    (clone / KERNEL).write_text(before, encoding="utf-8")
    assert NOTHING in snakemake(clone, *EVERYTHING, "--dry-run", *QUICK).stdout


def test_an_edit_during_a_run_is_seen_by_the_next_one(finished, tmp_path):
    folder = copy_checkout(finished.folder, tmp_path / "edited", "results", ".snakemake")
    plans = folder / "workflow/squeezefilm/studies/plans.py"
    before, cards = plans.read_text(encoding="utf-8"), folder / "results/quick/run_cards"
    words = [sys.executable, "-m", "snakemake", SCENES, "--forcerun", "plan", *QUICK]
    known = {*cards.glob("*.json")}
    with subprocess.Popen(words, cwd=folder, stderr=subprocess.DEVNULL) as running:
        while running.poll() is None and {*cards.glob("*.json")} == known:
            time.sleep(0.01)
        plans.write_text(before + "EDITED = True\n", encoding="utf-8")
        # Who looks at the plan meanwhile hides nothing from the next run.
        snakemake(folder, SCENES, "--dry-run", "--nolock", *QUICK)
    assert running.returncode == 0
    assert "Points to simulate: screen" in snakemake(folder, SCENES, "--dry-run", *QUICK).stdout
    plans.write_text(before, encoding="utf-8")
    assert NOTHING in snakemake(folder, SCENES, "--dry-run", *QUICK).stdout

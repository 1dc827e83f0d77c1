"""Every fault is caught, in the rows where it belongs, and what is no fault is not caught.

Most faults are put into copies of finished results, and cost little; a kernel, a seed and the way
a study is run are changed for real.
"""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from squeezefilm_workflow.paper.figures import FIGURES
from squeezefilm_workflow.reporting.check import PICTURES_FOLDER as PLACE
from squeezefilm_workflow.reporting.figures import style
from squeezefilm_workflow.reporting.figures.style import PLAIN_PICTURE_SUFFIX
from squeezefilm_workflow.reporting.results import Results as StudyResults

from ..workflow.conftest import QUICK, copy_checkout, snakemake
from .conftest import REFERENCE, TABLE, Failed, Results, failed_in


def items(failed: Failed, part: str) -> set[str]:
    return {item for of, item, _ in failed if of == part}


def edit(path: Path, change: Callable[[pd.DataFrame], pd.DataFrame]) -> None:
    """Change a table; the copy's files are links, so that the file is written anew."""
    table = change(pd.read_csv(path))
    path.unlink()
    table.to_csv(path, index=False)


def redraw(results: Results, name: str, change: Callable[[Figure], None]) -> None:
    """Draw a figure's picture anew, with something changed."""
    path = results.folder / PLACE / f"{name}{PLAIN_PICTURE_SUFFIX}"
    study = StudyResults.of_folder(results.folder, results.checkout / "config/quick.yaml")
    with style.figure_style(notes=False):
        figure, _ = FIGURES[f"figures/{name}"](study)
        change(figure)
        path.unlink()
        style.save_without_text(figure, [path])


# --- the study as it is -------------------------------------------------------------------------


def test_the_sound_study_is_green(sound):
    assert sound.status == 0, sound.log[-6000:]
    assert failed_in(sound.folder / TABLE) == set()
    count = len(pd.read_csv(sound.folder / TABLE))
    assert f"All {count} quantities that are compared passed;" in sound.log


def test_a_failed_check_ends_with_its_verdict_and_has_it_once(copy):
    """It stood before and after a list of all the inputs, eighty lines."""
    path = copy / REFERENCE / "quick/tables.csv"
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    table.assign(value=table["value"].where(table.index != 0, "other")).to_csv(path, index=False)
    done = snakemake(copy, "check", *QUICK)
    assert done.returncode != 0
    before, _, after = re.split(r"(\n1 of \d+ quantities failed\..*\n)", done.stdout)
    assert "Failed:" in before
    assert "results/quick/tables/table" in before[before.index("Files that failed:") :]
    assert len(after.splitlines()) < 10, after
    assert len(before[before.index("Error in rule") :].splitlines()) < 40


# --- faults in tables ---------------------------------------------------------------------------


SCREEN = "simulations/screen/forces.csv"
SIMULATIONS = "results/quick/simulations"
# Targets that hold every force, fit, design and claim of the paper.
NUMBERS = ("two_factor", "four_factor", "paper_tables")
SETTLING_COLUMNS = ("settling_start_s", "settling_stop_s", "lasting_fraction")
# A table, what is done to it, all rows of the check that fail.
FAULTS: dict[str, tuple[str, Callable[[pd.DataFrame], pd.DataFrame], Failed]] = {
    "a shifted column": (
        "figures/fig08.csv",
        lambda table: table.assign(force_n=np.roll(table["force_n"], 1)),
        {("figure data", "fig08", "force_n")},
    ),
    "a changed number of a figure": (
        "figures/fig14.csv",
        lambda table: table.assign(relative_error_percent=table["relative_error_percent"] + 0.5),
        {("figure data", "fig14", "relative_error_percent")},
    ),
    "a changed force": (
        SCREEN,
        lambda table: table.assign(force_n=table["force_n"] * (1 + 1e-3 * (table.index == 0))),
        {("simulations", "screen", "force_n")},
    ),
    "every time of the response": (
        "simulations/screen/response.csv",
        lambda table: table.assign(**{name: 2 * table[name] for name in SETTLING_COLUMNS}),
        {("results", "simulations/screen/response", name) for name in SETTLING_COLUMNS},
    ),
    "an error of an effect": (
        "simulations/screen/error_budget.csv",
        lambda table: table.assign(edge_flow_error_percent=3 * table["edge_flow_error_percent"]),
        {("results", "simulations/screen/error_budget", "edge_flow_error_percent")},
    ),
    "the validity of one point": (
        "simulations/screen/error_budget.csv",
        lambda table: table.assign(validity=table["validity"].where(table.index != 1, "nonsense")),
        {("results", "simulations/screen/error_budget", "validity")},
    ),
    "a claim that changes sides": (
        "claims.csv",
        lambda table: table.assign(
            verdict=table["verdict"].where(table["claim_id"] != "space", "differs because")
        ),
        {("claims", "space", "verdict")},
    ),
    "a film that fails": (
        "numerics/stability.csv",
        lambda table: table.assign(verdict=["failed", *table["verdict"][1:]]),
        {("numerics", "stability", "verdicts")},
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_a_table_is_caught_where_it_belongs(results, fault):
    table, change, expected = FAULTS[fault]
    edit(results.folder / table, change)
    assert results.failed() == expected


def test_a_worse_design_is_caught_and_an_equal_one_is_not(results):
    path = results.folder / "designs/four_factor.csv"
    original = pd.read_csv(path)
    # The point inside slides along its line of equal hv/h0, on which the model stays the same.
    inside = original["h0_m"].between(5.5e-6, 9.5e-6)
    assert inside.sum() == 1
    for column in ("h0_m", "hv_m"):
        edit(
            path,
            lambda table, c=column: table.assign(**{c: table[c].where(~inside, table[c] * 0.98)}),
        )
    assert results.failed() == set()
    edit(path, lambda table: table.assign(hv_m=table["hv_m"].where(~inside, 1.0e-6)))
    assert results.failed() == {("designs", "four_factor", "D-efficiency")}


# --- faults in pictures -------------------------------------------------------------------------


def without_curve(figure: Figure) -> None:
    """Drop one of the curves, which have a label and more than two points."""
    curves = [line for line in figure.axes[0].lines if not line.get_label().startswith("_")]
    max(curves, key=lambda line: len(line.get_xdata())).remove()


def without_band(figure: Figure) -> None:
    """Drop one of the two lines at ±15 %."""
    (line,) = [line for line in figure.axes[0].lines if set(line.get_ydata()) == {15.0}]
    line.remove()


PICTURES: dict[str, tuple[str, Callable[[Figure], None]]] = {
    "a dropped curve": ("fig14", without_curve),
    "a missing line of the band": ("fig14", without_band),
}


@pytest.mark.parametrize("fault", PICTURES)
def test_a_fault_in_a_picture_is_caught(results, fault):
    name, change = PICTURES[fault]
    redraw(results, name, change)
    assert results.failed() == {("pictures", name, "difference")}


# --- for real -----------------------------------------------------------------------------------


def test_a_factor_in_the_kernel_is_caught(copy):
    """Half the pressure's square, a hundredth too large, in the viscous flow."""
    path = copy / "workflow/squeezefilm/reynolds/periodic/film_over_period.cl"
    text = path.read_text(encoding="utf-8")
    assert text.count("p * (1.0 + 0.5 * p)") == 1
    path.write_text(text.replace("1.0 + 0.5 * p", "1.0 + 0.505 * p"), encoding="utf-8")
    plans = [f"{SIMULATIONS}/{plan}/forces.csv" for plan in ("screen", "error_map")]
    done = snakemake(copy, "--keep-going", *plans, "results/quick/numerics/stability.csv", *QUICK)
    assert done.returncode != 0
    # The stiff films know better than the kernel, and end the run before there is a table.
    (log,) = copy.glob("logs/quick/stability.log")
    assert "cases failed" in log.read_text(encoding="utf-8")
    failed = Results(copy / "results" / "quick", copy).failed()
    assert ("simulations", "screen", "force_n") in failed
    assert ("simulations", "error_map", "force_n") in failed
    # What follows from the settings alone is as it was.
    assert not items(failed, "figure data") & {"fig05", "fig06", "fig07", "fig15"}


def test_threads_chunks_and_cores_are_no_fault(sound, results, tmp_path):
    """Numbers anew with two threads of BLAS, one core, and each plan in more parts."""
    folder = copy_checkout(sound.folder, tmp_path / "checkout")
    path = folder / "config/quick.yaml"
    text, count = re.subn(
        r"seconds_per_job: \S+", "seconds_per_job: 0.01", path.read_text(encoding="utf-8")
    )
    assert count == 1
    path.write_text(text, encoding="utf-8")
    threads = {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
    done = snakemake(folder, *NUMBERS, "--cores", "1", *QUICK, environment=threads)
    assert done.returncode == 0, done.stdout[-6000:]
    parts = [
        len(list((each / SIMULATIONS).glob("*/chunks/*.timings.*")))
        for each in (folder, sound.folder)
    ]
    assert parts[0] > parts[1]
    for made in sorted((folder / "results/quick").rglob("*.*")):
        place = results.folder / made.relative_to(folder / "results/quick")
        place.unlink(missing_ok=True)  # it is a link
        place.parent.mkdir(parents=True, exist_ok=True)
        made.rename(place)
    assert results.failed() == set()

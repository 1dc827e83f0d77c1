"""Changes of an assumption that would explain a difference from the paper.

One assumption is changed at a time and the force simulated again. An assumption explains a
difference if a plausible value of it brings the force to the paper's, as far as the paper's digits
tell it. What is plausible was set from what the paper states, with how many digits, and from air.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from scipy.optimize import brentq

from squeezefilm.config.loading import with_changed_keys
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.studies.study import scene_of_study
from squeezefilm_workflow.reporting.notes import five_digit_text
from squeezefilm_workflow.reporting.pages import Page
from squeezefilm_workflow.reporting.results import Results

ForcesFunction = Callable[[Sequence[Scene]], np.ndarray]
"""The mean force of each scene in newtons; NaN where it cannot be simulated."""

ASSUMPTION_SEARCH_COUNT = 13
POINTS_IN_PLAUSIBLE_RANGE = 5


Assumption = Mapping[str, Any]
_ASSUMPTION_TABLE = yaml.safe_load(
    Path(__file__).with_name("assumptions.yaml").read_text(encoding="utf-8")
)
ASSUMPTIONS = [
    {"plausible": None, "rest": None, "switch": {}} | entry for entry in _ASSUMPTION_TABLE
]


def _force_differences(config: Study) -> Iterator[tuple[dict[str, Any], float, dict[str, float]]]:
    """The forces in which the paper's simulations and ours differ.

    For each how its rows begin, half a unit of the last digit of the paper's, and the point.
    """
    beyond, screen = config.extrapolation, config.screen
    operating = {"h0_m": beyond.h0_m, "hv_m": beyond.hv_m}
    smallest = {"h0_m": screen.h0_m.stop, "hv_m": screen.hv_m.start}
    for claim_id, force, paper_n, half_digit_n, point in (
        ("simulation_at_2.2", "force", 0.99, 0.005, operating),
        ("smallest_force", "smallest force of the screen,", 90e-6, 5e-6, smallest),
    ):
        claim = f"{force} at h0 = {1e6 * point['h0_m']:g} µm, hv = {1e6 * point['hv_m']:g} µm"
        yield {"claim_id": claim_id, "claim": claim, "paper_n": paper_n}, half_digit_n, point


def uncertainty_page(results: Results) -> Page:
    """The page of the study's differences from the paper; its forces are simulated for it."""
    config = results.config
    settings = solver_settings(config, outputs=())
    table = assumptions_table(config, forces=lambda scenes: settings.solve(scenes).force_n)
    differences = [
        {
            "claim": claim,
            "paper_n": rows["paper_n"].iloc[0],
            "ours_n": rows["ours_n"].iloc[0],
            "explaining": int((rows["verdict"] == "explains").sum()),
            "assumptions": _readable_assumptions(rows),
        }
        for claim, rows in table.groupby("claim", sort=False)
    ]
    return Page({"differences": differences}, {"csv": table})


def _readable_assumptions(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the assumptions of a difference for the page, their verdict first, ranges as texts."""

    def text_column(name: str) -> pd.Series:
        return rows[name].map(lambda value: five_digit_text(value) if np.isfinite(value) else "–")

    def range_column(name: str, unit: str = "") -> pd.Series:
        return text_column(f"{name}_lower{unit}") + " to " + text_column(f"{name}_upper{unit}")

    shown = {
        "assumption": rows["assumption"] + " (" + rows["unit"] + ")",
        "verdict": rows["verdict"],
        "assumed": text_column("assumed"),
        "plausible": range_column("plausible"),
        "force (N)": range_column("force", "_n"),
        "needed": text_column("needed"),
        "reached (N)": range_column("reached", "_n"),
        "source": rows["because"],
    }
    return pd.DataFrame(shown)


def assumptions_table(config: Study, *, forces: ForcesFunction) -> pd.DataFrame:
    """A row for each difference and assumption.

    It has, in the assumption's unit, what is assumed and plausible; the forces over the
    plausible values and over all that were tried; and ``needed``, the nearest value that gives the
    paper's force, NaN if none was found.

    Raises RunError when a film cannot be simulated even with everything as assumed.
    """
    rows: list[dict[str, Any]] = []
    for claim, half_n, point in _force_differences(config):
        (ours_n,) = forces([scene_of_study(config, **point)])
        if not np.isfinite(ours_n):
            raise RunError(f"{claim['claim_id']}: the film could not be simulated")
        begin = {**claim, "ours_n": float(ours_n)}
        for assumption in ASSUMPTIONS:
            rows += _assumption_rows(config, point, begin, half_n, assumption, forces)
    return pd.DataFrame(rows)


def _assumption_rows(
    config: Study,
    point: Mapping[str, float],
    begin: Mapping[str, Any],
    half_n: float,
    assumption: Assumption,
    forces: ForcesFunction,
) -> Iterator[dict[str, Any]]:
    """The row; none where the study's film does not know the assumption.

    Args:
        point: the operating point, which ``point`` in the assumption's places stands for.
        begin: how the row begins, the paper's and our force in it.
        half_n: rounding error of the paper's force, by its digits.
    """
    sections: Any = {**config.model_dump(exclude_none=True, by_alias=True), "point": point}
    paper_n, assumed = begin["paper_n"], assumption["rest"]
    if assumed is None:
        section, key = assumption["places"][0].rsplit(".", 1)
        values = reduce(getitem, section.split("."), sections)
        if key not in values:
            return
        assumed = float(values[key])

    def forces_with_values_n(values: np.ndarray) -> np.ndarray:
        """The forces with other values of the assumption; NaN where there is no such film."""
        scenes = {}
        for k, value in enumerate(values.tolist()):
            changed = dict.fromkeys(assumption["places"], value) | assumption["switch"]
            if value == assumption["rest"]:
                changed = {}
            at = {key: changed.pop(f"point.{key}", point[key]) for key in point}
            with suppress(InputError):
                scenes[k] = scene_of_study(with_changed_keys(config, changed), **at)
        scene_forces_n = np.full(len(values), np.nan)
        scene_forces_n[list(scenes)] = forces(list(scenes.values()))
        return scene_forces_n

    def excess_force_n(value: float) -> float:
        return float(forces_with_values_n(np.array([value]))[0] - paper_n)

    low, high = assumption["plausible"] or _rounding_interval(assumed, assumption["scale"])
    values = np.linspace(low, high, POINTS_IN_PLAUSIBLE_RANGE if high > low else 1)
    plausible = np.append(forces_with_values_n(values), begin["ours_n"])
    low_n, high_n = np.nanmin(plausible), np.nanmax(plausible)
    # From small to large, with that assumed among them.
    least, most = assumption["search"]
    values = np.linspace(least, most, ASSUMPTION_SEARCH_COUNT)
    if assumption["rest"] is None:
        tried = assumed * np.geomspace(least, most, ASSUMPTION_SEARCH_COUNT)
        values = np.unique(np.append(tried, assumed))
    reached = forces_with_values_n(values)
    off = reached - paper_n
    between = np.flatnonzero(off[:-1] * off[1:] <= 0)
    needed = [brentq(excess_force_n, *values[i : i + 2], rtol=1e-6) for i in between]
    nearest = min(needed, key=lambda value: abs(value - assumed), default=np.nan)
    explains = low_n <= paper_n + half_n and high_n >= paper_n - half_n
    yield {
        **begin,
        "assumption": assumption["name"],
        "unit": assumption["unit"],
        "assumed": assumed / assumption["scale"],
        "plausible_lower": low / assumption["scale"],
        "plausible_upper": high / assumption["scale"],
        "force_lower_n": low_n,
        "force_upper_n": high_n,
        "needed": nearest / assumption["scale"],
        "needed_change_percent": 100 * (nearest / assumed - 1) if assumed else np.nan,
        "reached_lower_n": np.nanmin([*reached, *plausible]),
        "reached_upper_n": np.nanmax([*reached, *plausible]),
        "verdict": "explains" if explains else "cannot explain",
        "because": assumption["because"],
    }


def _rounding_interval(value: float, scale: float) -> tuple[float, float]:
    """Least and largest value that rounds to the digits of one in its unit."""
    shown = value / scale
    half = 0.5 * 10.0 ** -len(f"{shown:g}".partition(".")[2])
    return (shown - half) * scale, (shown + half) * scale

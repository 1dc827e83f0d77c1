"""How far an assumption would have to move to explain a difference from the paper.

One assumption is changed at a time and the force simulated anew. An assumption explains a
difference if a plausible value of it brings the force to the paper's, as far as the paper's digits
tell it. What is plausible was set from what the paper states, with how many digits, and from air.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from scipy.optimize import brentq

from squeezefilm.config.loading import Config
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.tables import ScenePoint
from squeezefilm.studies.study import scene_of

Force = Callable[[Scene], float]
"""The mean force of a scene in newtons; NaN where it cannot be simulated."""

CURVE_REACH = 0.05
CURVE_POINTS = 21
SEARCH_POINTS = 13
PLAUSIBLE_POINTS = 5


@dataclass(frozen=True)
class Difference:
    """A force of the paper beside ours; low and high are what its digits may stand for.

    All in newtons; the point is where the force is taken.
    """

    claim_id: str
    claim: str
    paper_n: float
    low_n: float
    high_n: float
    point: ScenePoint


@dataclass(frozen=True)
class Assumption:
    """A number that the simulations take for granted.

    Attributes:
        places: where it stands in the configuration; ``point.hv_m`` for the point's own.
        unit, scale: the unit it is shown in, and that in SI.
        plausible: least and largest plausible value in SI; None for the point's two digits.
        because: where that comes from.
        search: least and largest value tried, as multiples of what is assumed, or plain values
            where it is assumed to be ``rest``.
        rest: the value at which the effect is absent; the study is then simulated without it.
        switch: what else has to be set for the number to count.
    """

    name: str
    places: Sequence[str]
    unit: str
    scale: float
    because: str
    search: tuple[float, float]
    plausible: tuple[float, float] | None = None
    rest: float | None = None
    switch: Mapping[str, str] = field(default_factory=dict)


_TABLE = Path(__file__).with_name("assumptions.yaml").read_text(encoding="utf-8")
ASSUMPTIONS = tuple(Assumption(**entry) for entry in yaml.safe_load(_TABLE))


def differences(config: Config) -> tuple[Difference, ...]:
    """The forces in which the paper's simulations and ours differ; sections as commands name them.

    The bounds are half a unit of the last digit that the paper gives.
    """
    beyond, screen = config["extrapolation"], config["screen"]
    smallest = (screen["h0_m"]["stop"], screen["hv_m"]["start"])
    return (
        Difference(
            "simulation_at_2.2",
            "force at {}",
            0.99,
            0.985,
            0.995,
            ScenePoint("operating_point", beyond["h0_m"], beyond["hv_m"]),
        ),
        Difference(
            "smallest_force",
            "smallest force of the screen, at {}",
            90e-6,
            85e-6,
            95e-6,
            ScenePoint("smallest", *smallest),
        ),
    )


@dataclass(frozen=True)
class Trial:
    """A difference and one assumption: the film with other values of it."""

    config: Config
    difference: Difference
    assumption: Assumption

    @property
    def assumed(self) -> float | None:
        """The value taken, in SI; None where the study's film does not know the assumption."""
        if self.assumption.rest is not None:
            return self.assumption.rest
        try:
            value: Any = self._values()
            for key in self.assumption.places[0].split("."):
                value = value[key]
            return float(value)
        except KeyError:
            return None

    @property
    def plausible(self) -> tuple[float, float]:
        """Least and largest plausible value, in SI."""
        if self.assumption.plausible is not None:
            return self.assumption.plausible
        value = self.difference.point.hv_m / self.assumption.scale
        half = 0.5 * 10.0 ** -len(f"{value:g}".partition(".")[2])
        return (value - half) * self.assumption.scale, (value + half) * self.assumption.scale

    def force_n(self, value: float, *, force: Force) -> float:
        """The force with another value of the assumption; NaN where there is no such film."""
        if value == self.assumption.rest:
            return force(scene_of(self.difference.point, self.config))
        values = self._values()
        settings: dict[str, Any] = dict.fromkeys(self.assumption.places, value)
        for place, setting in {**settings, **self.assumption.switch}.items():
            values = _changed(values, place.split("."), setting)
        point = ScenePoint(**(vars(self.difference.point) | values.pop("point")))
        try:
            return force(scene_of(point, Config(path=self.config.path, sections=values)))
        except InputError:
            return float("nan")

    def _values(self) -> dict[str, Any]:
        return {**self.config.sections, "point": {"hv_m": self.difference.point.hv_m}}


def _changed(values: dict[str, Any], place: Sequence[str], setting: Any) -> dict[str, Any]:
    """A copy of nested values with another one at a place."""
    key, *rest = place
    inner = _changed(values[key], rest, setting) if rest else setting
    return {**values, key: inner}


def compare(config: Config, *, force: Force) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The table, a row for each difference and assumption, and curves of force over change.

    The table's columns: claim_id, claim, paper_n, paper_low_n, paper_high_n, ours_n, assumption,
    unit, assumed, plausible_low, plausible_high (in the unit), force_low_n, force_high_n (over the
    plausible values), needed (nearest value that gives the paper's force; NaN if none was found),
    needed_change_percent, reached_low_n, reached_high_n (over all values tried), verdict, because.
    The curves': claim_id, assumption, change_percent, plausible, force_n, for assumptions that
    can change both ways.
    Raises RunError when a film cannot be simulated even with everything as assumed.
    """
    rows, curves = [], []
    for difference in differences(config):
        ours_n = force(scene_of(difference.point, config))
        if not np.isfinite(ours_n):
            raise RunError(f"point {difference.point.point_id}: the film could not be simulated")
        for assumption in ASSUMPTIONS:
            trial = Trial(config, difference, assumption)
            if trial.assumed is not None:
                rows.append(_row(trial, trial.assumed, ours_n, force))
                curves.append(_curve(trial, trial.assumed, force))
    return pd.DataFrame(rows), pd.concat(curves, ignore_index=True)


def _row(trial: Trial, assumed: float, ours_n: float, force: Force) -> dict[str, Any]:
    difference, assumption = trial.difference, trial.assumption
    low, high = trial.plausible
    points = PLAUSIBLE_POINTS if high > low else 1
    plausible = np.append(_forces(trial, np.linspace(low, high, points), force), ours_n)
    values = _searched(assumption, assumed)
    reached = _forces(trial, values, force)
    needed = _nearest_crossing(trial, values, reached, assumed, force)
    low_n, high_n = np.nanmin(plausible), np.nanmax(plausible)
    explains = low_n <= difference.high_n and high_n >= difference.low_n
    change = needed / assumed - 1 if assumed else np.nan
    point = difference.point
    return {
        "claim_id": difference.claim_id,
        "claim": difference.claim.format(
            f"h0 = {1e6 * point.h0_m:g} µm, hv = {1e6 * point.hv_m:g} µm"
        ),
        "paper_n": difference.paper_n,
        "paper_low_n": difference.low_n,
        "paper_high_n": difference.high_n,
        "ours_n": ours_n,
        "assumption": assumption.name,
        "unit": assumption.unit,
        "assumed": assumed / assumption.scale,
        "plausible_low": low / assumption.scale,
        "plausible_high": high / assumption.scale,
        "force_low_n": low_n,
        "force_high_n": high_n,
        "needed": needed / assumption.scale,
        "needed_change_percent": 100 * change,
        "reached_low_n": np.nanmin([*reached, *plausible]),
        "reached_high_n": np.nanmax([*reached, *plausible]),
        "verdict": "explains" if explains else "cannot explain",
        "because": assumption.because,
    }


def _searched(assumption: Assumption, assumed: float) -> np.ndarray:
    """Values to try, from small to large, with that assumed among them."""
    low, high = assumption.search
    if assumption.rest is not None:
        return np.linspace(low, high, SEARCH_POINTS)
    some = assumed * np.geomspace(low, high, SEARCH_POINTS)
    return np.unique(np.append(some, assumed))


def _forces(trial: Trial, values: Iterable[float], force: Force) -> np.ndarray:
    return np.array([trial.force_n(float(value), force=force) for value in values])


def _nearest_crossing(
    trial: Trial, values: np.ndarray, forces: np.ndarray, assumed: float, force: Force
) -> float:
    """The value nearest to the assumed one at which the force is the paper's; NaN if none is."""
    paper_n = trial.difference.paper_n
    off = forces - paper_n
    found = [
        brentq(
            lambda value: trial.force_n(value, force=force) - paper_n,
            values[i],
            values[i + 1],
            rtol=1e-6,
        )
        for i in range(len(values) - 1)
        if off[i] * off[i + 1] <= 0
    ]
    return float(min(found, key=lambda value: abs(value - assumed), default=np.nan))


def _curve(trial: Trial, assumed: float, force: Force) -> pd.DataFrame:
    """Force over a change of a few percent; without rows where only one direction has a sense."""
    share = np.linspace(-CURVE_REACH, CURVE_REACH, CURVE_POINTS)
    if trial.assumption.rest is not None:
        share = share[:0]
    low, high = trial.plausible
    values = assumed * (1 + share)
    ends = [each for each in (low, high) if values.size and values[0] < each < values[-1]]
    values = np.unique(np.append(values, ends))
    return pd.DataFrame(
        {
            "claim_id": trial.difference.claim_id,
            "assumption": trial.assumption.name,
            "change_percent": 100 * (values / assumed - 1) if values.size else values,
            "plausible": (values >= low) & (values <= high),
            "force_n": _forces(trial, values, force),
        }
    )


def to_markdown(table: pd.DataFrame) -> str:
    """The table for people."""
    shown = pd.DataFrame(
        {
            "force": table["claim"],
            "paper (N)": table["paper_n"].map("{:g}".format),
            "ours (N)": table["ours_n"].map("{:.4g}".format),
            "what if another": table["assumption"],
            "assumed": _values(table, "assumed"),
            "plausible": _ranges(table, "plausible_low", "plausible_high", "{:.5g}")
            + _unit(table)
            + ", "
            + table["because"],
            "force over that (N)": _ranges(table, "force_low_n", "force_high_n", "{:.4g}"),
            "needed for the paper's": _needed(table),
            "verdict": table["verdict"],
        }
    )
    explaining = table.groupby("claim", sort=False)["verdict"].agg(
        lambda verdicts: int((verdicts == "explains").sum())
    )
    said = "; ".join(f"{claim}: {count or 'none'}" for claim, count in explaining.items())
    return (
        "**What would explain a difference from the paper?** One assumption changed at a time, "
        f"each force simulated anew. Assumptions that explain – {said}.\n\n{markdown_table(shown)}"
    )


def _unit(table: pd.DataFrame) -> pd.Series:
    return table["unit"].map(lambda unit: "" if unit == "–" else f" {unit}")


def _values(table: pd.DataFrame, column: str) -> pd.Series:
    return table[column].map("{:.5g}".format) + _unit(table)


def _ranges(table: pd.DataFrame, low: str, high: str, form: str) -> pd.Series:
    pairs = zip(table[low], table[high], strict=True)
    texts = [(form.format(least), form.format(most)) for least, most in pairs]
    return pd.Series(
        [least if least == most else f"{least}–{most}" for least, most in texts], index=table.index
    )


def _needed(table: pd.DataFrame) -> pd.Series:
    reached = _ranges(table, "reached_low_n", "reached_high_n", "{:.4g}")
    change = table["needed_change_percent"].map("{:+.2g} %".format).str.replace("-", "−")
    value = _values(table, "needed") + np.where(
        table["needed_change_percent"].isna(), "", " (" + change + ")"
    )
    return value.where(table["needed"].notna(), "no value: " + reached + " N at all")

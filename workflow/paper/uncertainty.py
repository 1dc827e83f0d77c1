"""How far an assumption would have to move to explain a difference from the paper.

One assumption is changed at a time and the force simulated anew. An assumption explains a
difference if a plausible value of it brings the force to the paper's, as far as the paper's digits
tell it. What is plausible was set from what the paper states, with how many digits, and from air.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from scipy.optimize import brentq

from reporting.pages import Page, readable
from reporting.results import Results
from squeezefilm.config.loading import Config
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import solve
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.studies.study import scene_of

Force = Callable[[Scene], float]
"""The mean force of a scene in newtons; NaN where it cannot be simulated."""

SEARCH_POINTS = 13
PLAUSIBLE_POINTS = 5


@dataclass(frozen=True)
class Difference:
    """A force of the paper in newtons, half a unit of its last digit, and where it is taken."""

    claim_id: str
    claim: str
    paper_n: float
    half_digit_n: float
    point: Mapping[str, float]


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
    """The forces in which the paper's simulations and ours differ."""
    beyond, screen = config["extrapolation"], config["screen"]
    operating = {name: beyond[name] for name in ("h0_m", "hv_m")}
    smallest = {"h0_m": screen["h0_m"]["stop"], "hv_m": screen["hv_m"]["start"]}
    least = f"smallest force of the screen, at {_place(smallest)}"
    return (
        Difference("simulation_at_2.2", f"force at {_place(operating)}", 0.99, 0.005, operating),
        Difference("smallest_force", least, 90e-6, 5e-6, smallest),
    )


def _place(point: Mapping[str, float]) -> str:
    return f"h0 = {1e6 * point['h0_m']:g} µm, hv = {1e6 * point['hv_m']:g} µm"


@dataclass(frozen=True)
class Trial:
    """A difference and one assumption: the film with other values of it."""

    config: Config
    difference: Difference
    assumption: Assumption
    force: Force

    @property
    def assumed(self) -> float | None:
        """The value taken, in SI; None where the study's film does not know the assumption."""
        if self.assumption.rest is not None:
            return self.assumption.rest
        try:
            return float(reduce(getitem, self.assumption.places[0].split("."), self._values()))
        except KeyError:
            return None

    @property
    def plausible(self) -> tuple[float, float]:
        """Least and largest plausible value, in SI."""
        if self.assumption.plausible is not None:
            return self.assumption.plausible
        value = self.difference.point["hv_m"] / self.assumption.scale
        half = 0.5 * 10.0 ** -len(f"{value:g}".partition(".")[2])
        return (value - half) * self.assumption.scale, (value + half) * self.assumption.scale

    def force_n(self, value: float) -> float:
        """The force with another value of the assumption; NaN where there is no such film."""
        point, config = self.difference.point, self.config
        if value != self.assumption.rest:
            values = deepcopy(self._values())
            settings: dict[str, Any] = dict.fromkeys(self.assumption.places, value)
            for place, setting in {**settings, **self.assumption.switch}.items():
                *sections, key = place.split(".")
                reduce(getitem, sections, values)[key] = setting
            point = values.pop("point")
            config = Config(path=config.path, sections=values)
        try:
            return self.force(scene_of(config, **point))
        except InputError:
            return float("nan")

    def forces_n(self, values: np.ndarray) -> np.ndarray:
        """The forces with other values."""
        return np.array([self.force_n(float(value)) for value in values])

    def needed(self, values: np.ndarray, forces_n: np.ndarray, *, assumed: float) -> float:
        """The value nearest to the assumed one at which the force is the paper's; NaN if none is.

        Args:
            values, forces_n: tried, from small to large.
        """
        paper_n = self.difference.paper_n
        off = forces_n - paper_n
        found = [
            brentq(lambda value: self.force_n(value) - paper_n, *values[i : i + 2], rtol=1e-6)
            for i in np.flatnonzero(off[:-1] * off[1:] <= 0)
        ]
        return float(min(found, key=lambda value: abs(value - assumed), default=np.nan))

    def _values(self) -> Any:
        return {**self.config.sections, "point": self.difference.point}


def uncertainty_page(results: Results) -> Page:
    """The page of the study's differences from the paper; its forces are simulated for it."""
    config = results.config
    settings, device = solver_settings(config, outputs=()), device_of(config)

    def force(scene: Scene) -> float:
        [solution] = solve(settings.resolved([scene], device), **settings.how(device))
        return solution.force_n

    table = compare(config, force=force)
    explaining = (table["verdict"] == "explains").groupby(table["claim"], sort=False).sum()
    shown = readable(table.drop(columns="claim_id"))
    return Page({"explaining": explaining, "shown": shown}, {"csv": table})


def compare(config: Config, *, force: Force) -> pd.DataFrame:
    """A row for each difference and assumption.

    It has, in the assumption's unit, what is assumed and plausible; the forces over the
    plausible values and over all that were tried; and ``needed``, the nearest value that gives the
    paper's force, NaN if none was found.

    Raises RunError when a film cannot be simulated even with everything as assumed.
    """
    rows = []
    for difference in differences(config):
        ours_n = force(scene_of(config, **difference.point))
        if not np.isfinite(ours_n):
            raise RunError(f"{difference.claim_id}: the film could not be simulated")
        for assumption in ASSUMPTIONS:
            trial = Trial(config, difference, assumption, force)
            if trial.assumed is not None:
                rows.append(_row(trial, trial.assumed, ours_n))
    return pd.DataFrame(rows)


def _row(trial: Trial, assumed: float, ours_n: float) -> dict[str, Any]:
    difference, assumption = trial.difference, trial.assumption
    paper_n, half_n = difference.paper_n, difference.half_digit_n
    low, high = trial.plausible
    points = PLAUSIBLE_POINTS if high > low else 1
    plausible = np.append(trial.forces_n(np.linspace(low, high, points)), ours_n)
    low_n, high_n = np.nanmin(plausible), np.nanmax(plausible)
    # From small to large, with that assumed among them.
    values = np.linspace(*assumption.search, SEARCH_POINTS)
    if assumption.rest is None:
        tried = assumed * np.geomspace(*assumption.search, SEARCH_POINTS)
        values = np.unique(np.append(tried, assumed))
    reached = trial.forces_n(values)
    needed = trial.needed(values, reached, assumed=assumed)
    explains = low_n <= paper_n + half_n and high_n >= paper_n - half_n
    return {
        "claim_id": difference.claim_id,
        "claim": difference.claim,
        "paper_n": paper_n,
        "ours_n": ours_n,
        "assumption": assumption.name,
        "unit": assumption.unit,
        "assumed": assumed / assumption.scale,
        "plausible_low": low / assumption.scale,
        "plausible_high": high / assumption.scale,
        "force_low_n": low_n,
        "force_high_n": high_n,
        "needed": needed / assumption.scale,
        "needed_change_percent": 100 * (needed / assumed - 1) if assumed else np.nan,
        "reached_low_n": np.nanmin([*reached, *plausible]),
        "reached_high_n": np.nanmax([*reached, *plausible]),
        "verdict": "explains" if explains else "cannot explain",
        "because": assumption.because,
    }

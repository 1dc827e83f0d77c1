"""How far a fitted model is to be trusted at a point; the rule, for every place that says so.

A fit is judged by simulations that it never saw: points left out of it in turn, whose error is no
less than the fit's own there, or control points. Their errors are taken to change from point to
point no faster than SAFETY times the steepest change among them, more where they are few (a
Lipschitz bound: G. Beliakov, Interpolation of Lipschitz functions, J. Comput. Appl. Math. 196
(2006) 20-44, with the constant estimated from the data). So the error at a point is at most that at
any unseen simulation and the steepness times the distance to it. This is done for the error in
newtons and for the error over (hv/h0)², which a force follows; the lesser bound counts, and the
simulations' own error is added, and what the scan of a measured profile leaves open. A point is
trusted inside the ranges of the fitted points, also in hv/h0, where the bound is a small enough
share of the force.

The explorer's trust.js computes the same from the numbers of `Trust.to_dict`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import form_of
from squeezefilm.models.force_model import Factors

Array = NDArray[np.float64]

MOST_RELATIVE_ERROR = 0.15
"""Bound over force up to which a point is trusted, where no study says another."""
SAFETY, FEW_POINTS = 2.0, 20.0
"""The steepness is that of n points times SAFETY·(1 + FEW_POINTS/n): few see little of it."""
LEAST_POINTS = 10
"""Fewer unseen simulations than this tell nothing about the others."""
MOST_POINTS = 2500
"""Of more unseen simulations an evenly spaced part is used: all pairs of them are looked at."""
RANGED = ("h0_m", "hv_m", "epsilon")
PLACED = ("h0_m", "hv_m", "epsilon", "x_m", "y_m")
SLACK = 1e-9
BATCH = 4096


@dataclass(frozen=True, eq=False)
class Unseen:
    """n simulations that a fit never saw, each array of shape (n,).

    force_n: simulated; error_n: the model's force less the simulated one; simulation_error: the
    largest relative error of the simulated forces.
    """

    factors: Factors
    force_n: Array
    error_n: Array
    simulation_error: float

    @classmethod
    def of(
        cls, factors: Factors, *, model_n: ArrayLike, force_n: ArrayLike, force_error_n: ArrayLike
    ) -> Unseen:
        """From forces and the simulations' absolute errors, in newtons, shape (n,).

        Points at which the model is undefined are left out: there is no error to learn from.
        """
        model, force = np.asarray(model_n, dtype=float), np.asarray(force_n, dtype=float)
        known = np.isfinite(model) & np.isfinite(force) & (force != 0)
        relative = np.abs(np.asarray(force_error_n, dtype=float)[known] / force[known])
        return cls(
            factors.take(known),
            force[known],
            (model - force)[known],
            float(np.max(relative, initial=0.0)),
        )

    def take(self, which: Any) -> Unseen:
        """Some of the simulations, by a mask or by indices."""
        return Unseen(
            self.factors.take(which),
            self.force_n[which],
            self.error_n[which],
            self.simulation_error,
        )

    def joined(self, other: Unseen) -> Unseen:
        """These simulations and others."""
        factors = {
            name: np.concatenate([getattr(each.factors, name) for each in (self, other)])
            for name in ("h0_m", "hv_m", *self.factors.position)
        }
        return Unseen(
            Factors.of(**factors),
            np.concatenate([self.force_n, other.force_n]),
            np.concatenate([self.error_n, other.error_n]),
            max(self.simulation_error, other.simulation_error),
        )


@dataclass(frozen=True)
class Verdict:
    """What is known of a model's error at n points.

    error_n: its bound in newtons, shape (n,), NaN where there is none; distance: to the nearest
    unseen simulation, in shares of the fit's ranges, shape (n,); reasons: why a point is not
    trusted, empty where it is.
    """

    error_n: Array
    distance: Array
    reasons: tuple[str, ...]

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """Which points are trusted, shape (n,)."""
        return np.array([not reason for reason in self.reasons], dtype=bool)

    def within_percent(self, force_n: ArrayLike) -> Array:
        """The error's bound in per cent of the force, shape (n,); NaN where it is not trusted."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = 100 * self.error_n / np.abs(force_n)
        return np.where(self.trusted, share, np.nan)


@dataclass(frozen=True, eq=False)
class Trust:
    """The evidence of a fit: the points it was fitted to, and simulations that it never saw.

    scan_error: the largest share of a force that the scan of a measured profile leaves open, 0
    without a scan. No simulation shows it, as all have the same profile.
    """

    fitted: Factors
    unseen: Unseen
    scan_error: float = 0.0

    @classmethod
    def of(cls, fitted: Factors, unseen: Unseen | None, *, scan_error: float = 0.0) -> Trust:
        """From the fitted points and the unseen ones, if any; those outside the ranges say nothing
        of the points inside and are left out, as is an even part of too many."""
        bare = cls(fitted, unseen or _nothing())
        inside = np.array([not each for each in bare.outside(bare.unseen.factors)], dtype=bool)
        chosen = np.flatnonzero(inside)
        stride = -(-len(chosen) // MOST_POINTS)
        return cls(fitted, bare.unseen.take(chosen[:: max(1, stride)]), scan_error)

    def with_control(self, control: Unseen) -> Trust:
        """Judged by control points, and by those left out in turn where these are too few.

        Control points that were fitted are no evidence and are left out.
        """
        new = control.take(~self.was_fitted(control.factors))
        trust = Trust.of(self.fitted, new, scan_error=self.scan_error)
        if len(trust.unseen.force_n) >= LEAST_POINTS:
            return trust
        both = self.unseen.joined(trust.unseen)
        return Trust.of(self.fitted, both, scan_error=self.scan_error)

    def was_fitted(self, factors: Factors) -> NDArray[np.bool_]:
        """Which points are among the fitted ones, shape (n,)."""
        from scipy.spatial.distance import cdist  # slow to import

        nearest = cdist(self._places(factors), self._places(self.fitted)).min(axis=1)
        found: NDArray[np.bool_] = nearest <= SLACK
        return found

    @cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The least and the largest value of each of RANGED and the position's among the fitted."""
        off_centre = self.fitted.phi_r_m > 0  # every direction is the same at the centre
        values = {name: _column(self.fitted, name) for name in (*RANGED, *self.fitted.position)}
        if np.any(off_centre) and "phi_deg" in values:
            values["phi_deg"] = values["phi_deg"][off_centre]
        return {name: (float(np.min(v)), float(np.max(v))) for name, v in values.items()}

    @cached_property
    def widths(self) -> dict[str, float]:
        """What each of PLACED is divided by before distances are taken."""
        reach = self.ranges.get("phi_r_m", (0.0, 0.0))[1] or 1.0
        widths = {name: high - low or high or 1.0 for name, (low, high) in self.ranges.items()}
        return {name: widths.get(name, reach) for name in PLACED}

    @cached_property
    def steepness(self) -> tuple[float, float]:
        """Of the error per distance, in newtons, and of that over (hv/h0)²; safety included."""
        from scipy.spatial.distance import pdist

        count = len(self.unseen.force_n)
        if count < LEAST_POINTS:
            return np.inf, np.inf
        distance = pdist(self._places(self.unseen.factors))
        apart = distance > SLACK
        square = self.unseen.factors.epsilon**2
        safety = SAFETY * (1 + FEW_POINTS / count)
        slopes = [
            np.max(pdist(error[:, None])[apart] / distance[apart], initial=0.0)
            for error in (self.unseen.error_n, self.unseen.error_n / square)
        ]
        return float(safety * slopes[0]), float(safety * slopes[1])

    def judge(
        self, factors: Factors, force_n: ArrayLike, *, most: float = MOST_RELATIVE_ERROR
    ) -> Verdict:
        """What is known of the model's error at points, with its forces there in newtons.

        most: the bound, as a share of the force, up to which a point is trusted.
        """
        force = np.abs(np.asarray(force_n, dtype=float))
        count = len(self.unseen.force_n)
        distance, error = self._bounds(factors)
        error = error + (self.unseen.simulation_error + self.scan_error) * force
        scan = f"{100 * self.scan_error:.2g} % of it by the scan, " if self.scan_error else ""
        reasons = []
        for index, outside in enumerate(self.outside(factors)):
            reason = outside
            if not outside and count < LEAST_POINTS:
                reason = (
                    f"judged by {count} simulations that the fit never saw, too few: "
                    f"{LEAST_POINTS} are needed (--control)"
                )
            elif not outside and not error[index] <= most * force[index]:
                reason = (
                    f"may be off by {100 * error[index] / force[index]:.3g} %, {scan}the nearest "
                    f"simulation that the fit never saw is {distance[index]:.2g} of its ranges away"
                )
            if not np.isfinite(force[index]):
                reason = "; ".join(filter(None, [outside, "undefined here"]))
            reasons.append(reason)
        return Verdict(np.where(np.isfinite(error), error, np.nan), distance, tuple(reasons))

    def outside(self, factors: Factors) -> list[str]:
        """For each point, what of it lies outside the ranges of the fitted points."""
        notes: list[list[str]] = [[] for _ in range(len(factors))]
        for name, (low, high) in self.ranges.items():
            values = _column(factors, name)
            slack = SLACK * max(abs(low), abs(high))
            out = (values < low - slack) | (values > high + slack)
            if name == "phi_deg":
                out &= factors.phi_r_m > SLACK * self.ranges["phi_r_m"][1]
            word = "hv_m/h0_m" if name == "epsilon" else name
            for index in np.flatnonzero(out):
                notes[index].append(f"{word} outside {low:.4g} … {high:.4g}")
        return ["; ".join(each) for each in notes]

    def _bounds(self, factors: Factors) -> tuple[Array, Array]:
        """Distance to the nearest unseen simulation, and the error's bound in newtons."""
        from scipy.spatial.distance import cdist

        known, unseen = self._places(self.unseen.factors), self.unseen
        distance, bound = np.full(len(factors), np.inf), np.full(len(factors), np.inf)
        if len(known) < LEAST_POINTS:
            return distance, bound
        places, square = self._places(factors), factors.epsilon**2
        error, over_square = np.abs(unseen.error_n), np.abs(unseen.error_n)
        over_square = over_square / unseen.factors.epsilon**2
        for start in range(0, len(factors), BATCH):
            some = slice(start, start + BATCH)
            away = cdist(places[some], known)
            plain = np.min(error + self.steepness[0] * away, axis=1)
            scaled = np.min(over_square + self.steepness[1] * away, axis=1) * square[some]
            distance[some], bound[some] = away.min(axis=1), np.minimum(plain, scaled)
        return distance, bound

    def _places(self, factors: Factors) -> Array:
        """Points where distances between them are taken, shape (n, 5)."""
        return np.column_stack([_column(factors, name) / self.widths[name] for name in PLACED])

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and lists, ready for JSON: the points, and what follows from them."""
        stored = ("h0_m", "hv_m", *self.fitted.position)
        unseen = {name: getattr(self.unseen.factors, name).tolist() for name in stored}
        return {
            "fitted": {name: getattr(self.fitted, name).tolist() for name in stored},
            "unseen": unseen
            | {"force_n": self.unseen.force_n.tolist(), "error_n": self.unseen.error_n.tolist()},
            "simulation_error": self.unseen.simulation_error,
            "scan_error": self.scan_error,
            "ranges": {name: list(limits) for name, limits in self.ranges.items()},
            "widths": self.widths,
            "steepness": [each if np.isfinite(each) else None for each in self.steepness],
            "least_points": LEAST_POINTS,
        }

    @classmethod
    def from_dict(cls, plain: Any, *, place: str) -> Trust:
        """The evidence written by to_dict; what follows from the points is computed anew.

        Raises InputError naming the place, for anything else.
        """
        try:
            stored = ("h0_m", "hv_m", *form_of(plain["fitted"]))
            fitted = Factors.of(**{name: plain["fitted"][name] for name in stored})
            given = plain["unseen"]
            force, error = (np.asarray(given[name], float) for name in ("force_n", "error_n"))
            points = Factors.of(**{name: given[name] for name in stored}) if len(force) else None
            simulation_error = float(plain["simulation_error"])
            scan_error = float(plain["scan_error"])
        except (KeyError, TypeError, ValueError, InputError):
            raise InputError(f"{place}: not the evidence of a fit, as `fit` writes it") from None
        if points is None:
            return cls.of(fitted, None, scan_error=scan_error)
        if not (force.shape == error.shape == (len(points),) and np.all(np.isfinite(error))):
            raise InputError(f"{place}: not the evidence of a fit, as `fit` writes it")
        unseen = Unseen(points, force, error, simulation_error)
        return cls.of(fitted, unseen, scan_error=scan_error)


def _column(factors: Factors, name: str) -> Array:
    return np.asarray(getattr(factors, name), dtype=float)


def _nothing() -> Unseen:
    none = np.empty(0)
    return Unseen(Factors.of(h0_m=none, hv_m=none), none, none, 0.0)

"""Errors of a fitted model: at points it was not fitted to, and its prediction interval.

In cross-validation points of one gap and amplitude are held out together, wherever the pad is:
where a force hardly depends on its position they are copies, and no point is unseen whose copy was
fitted.

The prediction interval is measured on a validation sample.

The sample is simulated at points that are independent and uniform over the declared space and that
no fit uses. Half of it ranks models; the other half calibrates the interval by split conformal
prediction (J. Lei et al., Distribution-free predictive inference for regression, J. Am. Stat.
Assoc.

113 (2018) 1094-1111): the score of a point is the model's error there plus the simulation's own,
divided by a scale; the k-th smallest of n scores, k = ⌈(n + 1) p⌉, times the scale is the half
width that holds a share p of new points of the same distribution. The scale a + b·|force| makes the
width local. It comes from the residuals of the cross-validation, so that the sample does not decide
it. A point without a force, simulated or modelled, has an infinite score.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, ConfigDict, computed_field, model_validator

from squeezefilm.columns import COLUMNS
from squeezefilm.errors import InputError
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS
from squeezefilm.lazy import pd
from squeezefilm.models.data import Array, Factors
from squeezefilm.models.fitting import local_fit_theta
from squeezefilm.models.force_model import ExpressionModel
from squeezefilm.units import error_text

PROFILE_UNCERTAINTY_LEVEL = 0.95
"""Level at which the uncertainty of a measured profile is stated."""
DEFAULT_SCALE_FRACTION = 0.1
"""Constant part of the scale over the mean force, where no residual tells it."""
NORMAL_QUANTILES = {0.95: 1.959964, 0.99: 2.575829}
"""Levels of the interval, with the two-sided quantile of the normal distribution (for noise)."""
NAMES_OF_THIRDS = ("low", "middle", "high")
MIN_COVERAGE = 0.9
"""Coverage of a region by the 95 % interval below which its points have a note."""


class LowCoverageRegion(NamedTuple):
    """A range of a quantity in which the 95 % interval holds too few points of the sample.

    Attributes:
        quantity: a column of factors, or ``epsilon``.
        lower, upper: ends in SI units, the upper one outside; None for an open end.
        note: what is stated of a point in the range.
    """

    quantity: str
    lower: float | None
    upper: float | None
    note: str


class PredictionInterval(BaseModel):
    """Half widths that hold 95 % and 99 % of new points of the declared space.

    Attributes:
        ranges: lower and upper limit of each factor of the declared space, by its column.
        error_95, error_99: constant part in newtons and share of the modelled force; None where
            the sample leaves the interval infinite.
        points: simulations of the sample; ``failed`` of them have no force, or no modelled one.
        calibration_points: those that the half widths come from.
        mean_coverage: share of the other half inside the 95 % interval without the part of the
            profile, whose error models and simulations share.
        coverage: the same by region (``factor_thirds``), with the ends of each third.
        profile_uncertainty: fraction of a force, uncertainty by a measured profile at 95 %; it is
            part of error_95 and error_99.
    """

    model_config = ConfigDict(frozen=True)

    ranges: dict[str, tuple[float, float]]
    error_95: tuple[float, float] | None
    error_99: tuple[float, float] | None
    points: int
    failed: int
    calibration_points: int
    mean_coverage: float
    coverage: tuple[dict[str, Any], ...] = ()
    profile_uncertainty: float = 0.0

    @model_validator(mode="after")
    def _check_range_names(self) -> PredictionInterval:
        if (
            not {"h0_m", "hv_m"}
            <= set(self.ranges)
            <= {"h0_m", "hv_m", *POLAR_COLUMNS, *CARTESIAN_COLUMNS}
        ):
            raise ValueError(f"ranges must be of h0_m, hv_m and of a position, not {self.ranges}")
        return self

    @computed_field  # type: ignore[prop-decorator]
    @property
    def statement(self) -> str:
        """A sentence about the interval, for every output."""
        sample = f"{self.points} independent simulations" + (
            f", {self.failed} of which have no force," if self.failed else ""
        )
        if self.error_95 is None:
            return f"Not validated: of {sample} too few have a force for a 95 % interval."
        scan = error_text(100 * self.profile_uncertainty)
        without = f" less the {scan} % of the scan" if self.profile_uncertainty else ""
        return (
            f"Of points drawn uniformly from the declared space ({self.space_name}), 95 % have a "
            f"simulated force within the stated 95 % error{without}, as measured on "
            f"{self.calibration_points} of {sample}; single points can lie outside."
        )

    @property
    def error_95_text(self) -> str:
        """The 95 % half width at a force, as text; empty where it is infinite."""
        if self.error_95 is None:
            return ""
        constant_n, relative = self.error_95
        return f"± ({error_text(constant_n)} N + {error_text(100 * relative)} % of the force)"

    @property
    def space_name(self) -> str:
        """The declared space in words."""
        parts = []
        for name in (name for name in COLUMNS if name in self.ranges):  # a file sorts them
            column, (low, high) = COLUMNS[name], self.ranges[name]
            extent = " to ".join(f"{column.in_shown_unit(end):.4g}" for end in sorted({low, high}))
            parts.append(f"{column.text_symbol} {extent} {column.shown_unit}")
        return ", ".join(parts)

    def error_n(self, force_n: ArrayLike, *, level: float = 0.95) -> Array:
        """Half width in newtons at modelled forces, shape (n,); NaN where it is infinite."""
        parts = self.error_95 if level == 0.95 else self.error_99
        constant, relative = parts or (np.nan, np.nan)
        return constant + relative * np.abs(np.asarray(force_n, dtype=float))

    def range_notes(self, factors: Factors) -> list[str]:
        """Factors of each point outside the declared space, empty where there are none."""
        notes = np.full(len(factors), "", dtype=object)
        for name, out in factors.outside_masks(self.ranges).items():
            column = COLUMNS[name]
            low, high = (f"{column.in_shown_unit(end):.4g}" for end in self.ranges[name])
            for point in np.flatnonzero(out):
                value = column.in_shown_unit(factors.column(name)[point])
                notes[point] += (
                    f"; {column.text_symbol} = {value:.4g} {column.shown_unit} "
                    f"outside {low} … {high} {column.shown_unit}"
                )
        return [note.removeprefix("; ") for note in notes]

    def coverage_notes(self, factors: Factors) -> list[str]:
        """Regions of each point where the interval holds few points of the sample, else empty.

        A file of a version that did not write the ends of the regions has no such notes.
        """
        notes = np.full(len(factors), "", dtype=object)
        for region in self.low_coverage_regions():
            values, low, high = factors.column(region.quantity), region.lower, region.upper
            inside = (values >= (-np.inf if low is None else low)) & (
                values < (np.inf if high is None else high)
            )
            notes[inside] += f"; {region.note}"
        return [note.removeprefix("; ") for note in notes]

    def low_coverage_regions(self) -> list[LowCoverageRegion]:
        """Return the regions in which the interval holds too few points of the sample."""
        error = "the 95 % error" + " without the scan" * bool(self.profile_uncertainty)
        return [
            LowCoverageRegion(
                **{end: region[end] for end in ("quantity", "lower", "upper")},
                note=f"{error} holds {100 * region['coverage']:.3g} % of {region['points']} "
                f"validation points in the {region['third']} third of the "
                f"{COLUMNS[region['quantity']].label}",
            )
            for region in self.coverage
            if region["coverage"] < MIN_COVERAGE and "upper" in region
        ]


def fold_indices_of_points(factors: Factors, *, folds: int, seed: int) -> NDArray[np.int64]:
    """Fold of each point, shape (n,): of as many as asked for, or as there are pairs of a gap and
    an amplitude if these are fewer; all points of a pair belong to one."""
    films = pd.DataFrame({"h0_m": factors.h0_m, "hv_m": factors.hv_m})
    film = films.groupby(["h0_m", "hv_m"], sort=False).ngroup().to_numpy()
    return np.random.default_rng(seed).permutation(np.arange(film.max() + 1) % folds)[film]


def held_out_predictions(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    theta: ArrayLike,
    folds: NDArray[np.int64],
) -> Array:
    """Each point's force by the model fitted to the other folds of films, in newtons, shape (n,).

    ``theta`` is where the fits start: that of all points; ``folds`` are those of
    ``fold_indices_of_points``. NaN where the model, fitted to the others, is undefined, and
    everywhere where a fold leaves fewer points than parameters. Raises InputError where a fit is
    impossible.
    """
    force = np.asarray(force_n, dtype=float)
    predicted = np.full(len(force), np.nan)
    if len(force) - np.bincount(folds).max() < max(len(model.parameter_names), 1):
        return predicted
    for fold in np.unique(folds):
        out = folds == fold
        fold_theta = local_fit_theta(model, factors.take(~out), force[~out], theta)
        predicted[out] = model.evaluate(fold_theta, factors.take(out))
    return predicted


def relative_errors(*, model_n: ArrayLike, simulation_n: ArrayLike) -> Array:
    """(model - simulation)/simulation for each point, shape (n,), from forces in newtons.

    Raises InputError for forces that are not finite, for none, or for a
    simulated force of zero.
    """
    model, simulation = np.array([model_n, simulation_n], dtype=float)
    if not len(model):
        raise InputError("validation: no points; give at least one")
    if not np.isfinite([model, simulation]).all():
        raise InputError("validation: a force is not a finite number; all must be")
    if np.any(simulation == 0):
        raise InputError("validation: a simulated force is zero; its relative error is undefined")
    return np.asarray((model - simulation) / simulation)


def error_statistics(*, model_n: ArrayLike, simulation_n: ArrayLike) -> dict[str, float]:
    """Errors of modelled against simulated forces, both in newtons, shape (n,), in four numbers.

    ``global_error`` is |model - simulation|/|simulation|, ``root_mean_square_n`` and ``largest_n``
    are in newtons, ``largest_relative`` is the largest relative error in magnitude. Raises
    InputError as relative_errors does.
    """
    relative = relative_errors(model_n=model_n, simulation_n=simulation_n)
    error = np.asarray(model_n) - np.asarray(simulation_n)
    return {
        "global_error": float(np.linalg.norm(error) / np.linalg.norm(simulation_n)),
        "root_mean_square_n": float(np.sqrt(np.mean(error**2))),
        "largest_n": float(np.max(np.abs(error))),
        "largest_relative": float(np.max(np.abs(relative))),
    }


def error_scale_of_residuals(residual_n: ArrayLike, force_n: ArrayLike) -> tuple[float, float]:
    """Constant a in newtons and share b of a scale a + b·|force| of a model's errors.

    From the residuals at held-out points, shape (n,), by non-negative least squares on
    their magnitudes. Without any (NaN) the share is 1 and the constant DEFAULT_SCALE_FRACTION of
    the mean force.
    """
    from scipy.optimize import nnls  # slow to import

    residual, force = (np.abs(np.asarray(values, dtype=float)) for values in (residual_n, force_n))
    mean, known = float(force.mean()), np.isfinite(residual)
    residual, force = residual[known], force[known]
    largest = float(np.max(force, initial=0.0))
    if not largest or not np.any(residual):
        return DEFAULT_SCALE_FRACTION * mean, 1.0
    columns = np.column_stack([np.ones(len(force)), force / largest])
    (constant, relative), _ = nnls(columns, residual)
    # A scale of zero at zero force would leave the errors there without a finite score.
    return max(float(constant), 1e-3 * float(residual.mean())), float(relative) / largest


def ranking_points_mask(points: int) -> NDArray[np.bool_]:
    """Mask of the validation points that rank models, shape (points,); the others calibrate."""
    return np.arange(points) % 2 == 0


def conformal_interval(
    factors: Factors,
    *,
    model_n: ArrayLike,
    force_n: ArrayLike,
    force_error_n: ArrayLike,
    scale: tuple[float, float],
    ranges: Mapping[str, tuple[float, float]],
    profile_uncertainty: float = 0.0,
) -> PredictionInterval:
    """The prediction interval of a model from its forces and simulated ones, shape (n,).

    Args:
        factors: n independent points, uniform over the declared space.
        force_n, force_error_n: simulated forces and their numerical errors; NaN where there is
            none.
        scale: what ``error_scale_of_residuals`` returns.
        ranges: of the declared space.
        profile_uncertainty: fraction of a force, uncertainty by a measured profile at 95 %.
    """
    model, force, own = np.array([model_n, force_n, force_error_n], dtype=float)
    constant, relative = scale
    score = (np.abs(model - force) + own) / (constant + relative * np.abs(model))
    score[~np.isfinite(score)] = np.inf
    ranking = ranking_points_mask(len(score))
    calibration = np.append(np.sort(score[~ranking]), np.inf)
    errors, quantiles = [], []
    for level, normal in NORMAL_QUANTILES.items():
        quantiles.append(quantile := calibration[ceil(len(calibration) * level) - 1])
        scan = profile_uncertainty * normal / NORMAL_QUANTILES[PROFILE_UNCERTAINTY_LEVEL]
        known = np.isfinite(quantile)
        errors.append((constant * quantile, relative * quantile + scan) if known else None)
    inside = np.isfinite(score) & (score <= quantiles[0])
    return PredictionInterval(
        ranges=dict(ranges),
        error_95=errors[0],
        error_99=errors[1],
        points=len(score),
        failed=int(np.sum(~np.isfinite(score))),
        calibration_points=int(np.sum(~ranking)),
        mean_coverage=float(inside[ranking].mean()),
        coverage=tuple(
            {
                "quantity": name,
                "third": third,
                "lower": lower,
                "upper": upper,
                "points": int(mask.sum()),
                "coverage": float(inside[ranking][mask].mean()),
            }
            for name, third, (lower, upper), mask in factor_thirds(factors.take(ranking))
        ),
        profile_uncertainty=profile_uncertainty,
    )


def factor_thirds(
    factors: Factors,
) -> Iterator[tuple[str, str, tuple[float | None, float | None], NDArray[np.bool_]]]:
    """Each quantity that varies with each of its thirds: its ends and a mask of its points, (n,).

    A quantity's range is cut at its terciles over the points, which fill the space evenly; the
    outer ends are None.
    """
    for name in ("h0_m", "hv_m", "epsilon", *factors.position_columns):
        values = factors.column(name)
        if len(values) and np.ptp(values) > 0:
            terciles = np.quantile(values, [1 / 3, 2 / 3])
            part, ends = np.digitize(values, terciles), [None, *terciles.tolist(), None]
            for k, third in enumerate(NAMES_OF_THIRDS):
                if k in part:
                    yield name, third, (ends[k], ends[k + 1]), part == k


def error_by_region_text(factors: Factors, error_n: ArrayLike) -> str:
    """The two quantities whose thirds hold the largest shares of the squared error, in words.

    factors hold n points that fill the space evenly, error_n the errors there in newtons. Raises
    InputError where no error is known.
    """
    error = np.asarray(error_n, dtype=float)
    squares = np.where(np.isfinite(error), error, 0.0) ** 2
    if not squares.sum() > 0:
        raise InputError("error by region: no error is known, or all are zero")
    worst: dict[str, tuple[float, str]] = {}
    for name, third, _, inside in factor_thirds(factors):
        fraction = float(squares[inside].sum() / squares.sum())
        if fraction > worst.get(name, (0.0, ""))[0]:
            worst[name] = fraction, f"{third} third of the {COLUMNS[name].label}"
    ordered = sorted(worst.values(), key=lambda fraction_and_region: -fraction_and_region[0])[:2]
    return "; ".join(
        f"{100 * fraction:.0f} % of the squared error lies in the {where}"
        for fraction, where in ordered
    )

"""A fitted model as its file holds it: all that its users need, without the study it came from.

And its use: forces with their errors, and the amplitude at which a film gives a target force.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainSerializer,
    StrictFloat,
    StrictInt,
    ValidationError,
    field_validator,
)

from squeezefilm.errors import InputError
from squeezefilm.files import read_json
from squeezefilm.film.pad import GapShape, Pad
from squeezefilm.film.positions import POLAR_COLUMNS
from squeezefilm.film.profiles import Piston
from squeezefilm.film.scene import Actuator, Film, Gas
from squeezefilm.film.surfaces import Disc, Rectangle
from squeezefilm.film.symmetry import Symmetry, symmetry_from_dict
from squeezefilm.film.validity import (
    OK,
    contact_text,
    off_surface_text,
    on_surface_mask,
    validity_texts,
)
from squeezefilm.models.data import PHYSICS_COLUMN_OF_NAME, Array, Factors
from squeezefilm.models.force_model import ExpressionModel, make_model
from squeezefilm.models.limit_table import LimitTable
from squeezefilm.models.prediction_interval import PredictionInterval

UNKNOWN_PREFIX = "not known: "
FILM_UNKNOWN_TEXT = f"{UNKNOWN_PREFIX}the fit's file does not describe its film"
SURFACE_UNKNOWN_TEXT = (
    f"{UNKNOWN_PREFIX}the fit's file does not describe the surface, so that the pad may lie off it"
)
NO_VALIDATION_SAMPLE_TEXT = "the fit has no validation sample (`squeezefilm fit --sample`)"
FIT_FILE_FORMAT_VERSION = 1
"""Of the file: counted up where a reader of the one before could not use it."""
REQUIRED_KEYS = (
    "parameter_units",
    "ranges",
    "error_scale",
    "profile_uncertainty",
    "directions",
    "film",
)
"""What a file has besides: without them an error or a limit would be missing unseen."""
TRIAL_AMPLITUDE_COUNT = 400
"""Places at which a model is looked at before the one for a target force is refined."""
AMPLITUDE_DIFFERENCE_STEP = 1e-4
"""Relative step of the amplitude in the slope of the force."""


class PadOfFit(BaseModel):
    """The pad of a fit's film, as far as limits of validity and its room on the surface go."""

    length_x_m: float
    length_y_m: float
    gap: GapShape
    edge_points_m: tuple[tuple[float, float], ...] = ()


class FilmOfFit(BaseModel):
    """The film of a fit's simulations, as far as limits of validity go.

    Attributes:
        surface: None in a file of a version that did not write it.
    """

    gas: Annotated[Gas, PlainSerializer(asdict)]
    frequency_hz: float
    pad: PadOfFit
    surface: Disc | Rectangle | None = None

    @field_validator("gas", mode="before")
    @classmethod
    def _require_complete_gas(cls, values: Any) -> Any:
        names = [attribute.name for attribute in fields(Gas)] if isinstance(values, Mapping) else []
        if missing := [name for name in names if name not in values]:
            raise ValueError(f"{', '.join(missing)}: not there")
        return values


class FittedModel(BaseModel):
    """Parameters (theta4 in 1/m), their number of points, and the residual on those points.

    global_error is |y − η|/|y|, sum_of_squares in N². ranges are the least and the largest value
    of each factor's column that the model was fitted on; cross_validation holds the errors at
    held-out points, where there are enough of them; interval, ``validation`` in the file, is the
    prediction interval of a validation sample. error_scale is what ``prediction_interval``'s
    function of that name returns, profile_uncertainty the largest uncertainty of a force
    by the scan of the study's profile, a fraction, at 95 %. What else the file has is kept.
    """

    model_config = ConfigDict(frozen=True, extra="allow", populate_by_name=True)

    format: StrictInt = FIT_FILE_FORMAT_VERSION
    model: str
    theta: tuple[StrictFloat, ...]
    points: StrictInt
    global_error: StrictFloat
    sum_of_squares: StrictFloat
    expression: str
    constants: dict[str, str | float] = {}
    parameters: list[str]
    parameter_units: list[str]
    parameter_ranges: list[dict[str, Any]] = []
    parameter_notes: list[str] = []
    ranges: dict[str, tuple[StrictFloat, StrictFloat]] = {}
    cross_validation: dict[str, StrictInt | StrictFloat] | None = None
    prediction_interval: PredictionInterval | None = Field(None, alias="validation")
    error_scale: tuple[float, float] = (0.0, 1.0)
    profile_uncertainty: float = 0.0
    limit_table: LimitTable | None = None
    directions: Any = None
    film: FilmOfFit | None = None
    source: dict[str, Any] = {}
    file: str = Field("fit", exclude=True)
    """The file, for messages."""

    def to_dict(self) -> dict[str, Any]:
        """Content of the file, ready for JSON."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)

    @cached_property
    def force_model(self) -> ExpressionModel:
        """The model with the formula that the file carries.

        Raises InputError naming the file, for an invalid formula.
        """
        if len(self.parameters) != len(self.parameter_units):
            raise InputError(f"{self.file}: give one of 'parameter_units' for each parameter")
        parameters = dict(zip(self.parameters, self.parameter_units, strict=True))
        entry = {
            "expression": self.expression,
            "constants": self.constants,
            "parameters": parameters,
        }
        model = make_model(self.model, entry, source=self.file)
        if len(model.parameter_names) != len(self.theta):
            raise InputError(
                f"{self.file}: 'theta' has {len(self.theta)} numbers for the parameters "
                f"{', '.join(model.parameter_names)}"
            )
        return model

    @cached_property
    def symmetry(self) -> Symmetry | None:
        """The pad's positions that represent all in the model's study, if the file has them."""
        if self.directions is None:
            return None
        return symmetry_from_dict(self.directions, source=f"{self.file}: directions")

    @property
    def position_columns(self) -> tuple[str, str]:
        """The form of positions in the model's study; polar, if the file has none."""
        return POLAR_COLUMNS if self.symmetry is None else self.symmetry.position_columns

    def folded_factors(self, factors: Factors) -> Factors:
        """The factors of the same forces with the pad in positions that the model knows.

        By the symmetry of the study's scenes; a file without one leaves them as they are.
        """
        if self.symmetry is None:
            return factors
        given = {name: factors.column(name) for name in self.symmetry.position_columns}
        kept = ("h0_m", "hv_m", *PHYSICS_COLUMN_OF_NAME.values())
        kept_columns = {name: column for name, column in factors.columns.items() if name in kept}
        return Factors.of(**kept_columns, **self.symmetry.representative_positions(**given))

    @property
    def required_asymptote_table(self) -> LimitTable | None:
        """The table of the asymptotic forces that the model uses, if it uses them.

        Raises InputError naming the file, where it has no such table.
        """
        names = self.force_model.column_names
        if names and self.limit_table is None:
            raise InputError(
                f"{self.file}: the model {self.model} needs {', '.join(names)} and its file has "
                "no table of them: they do not hold all over its study's space"
            )
        return self.limit_table if names else None

    def with_asymptotic_forces(self, factors: Factors) -> Factors:
        """The factors with the asymptotic forces that the model needs, from the file's own table.

        Raises InputError as ``required_limit_table``.
        """
        known = all(name in factors.columns for name in self.force_model.column_names)
        table = None if known else self.required_asymptote_table
        return factors if table is None else table.with_asymptotic_forces(factors)

    def evaluate(self, factors: Factors) -> Array:
        """The model's forces in newtons, shape (n,); NaN where it is undefined."""
        return self.force_model.evaluate(self.theta, self.with_asymptotic_forces(factors))

    def no_film_texts(self, factors: Factors) -> list[str]:
        """Reasons for no film: surface and pad touch, or the pad lies off the surface; else empty.

        Of a file without the surface only whether they touch is known.
        """
        h0_m, hv_m, x_m, y_m = (factors.column(name) for name in ("h0_m", "hv_m", "x_m", "y_m"))
        texts = np.full(len(factors), "", dtype=object)
        if self.film is not None and (surface := self.film.surface):
            outline_m = np.array(self.film.pad.edge_points_m)
            for point in np.flatnonzero(~on_surface_mask(outline_m, surface, x_m=x_m, y_m=y_m)):
                texts[point] = off_surface_text(outline_m, surface, x_m=x_m[point], y_m=y_m[point])
        for point in np.flatnonzero(hv_m >= h0_m):
            texts[point] = contact_text(h0_m[point], hv_m[point])
        return list(texts)

    def validity(self, factors: Factors) -> list[str]:
        """``ok``, why there is no film, the limits of validity that it exceeds, or what is unknown.

        As if the profile's maximum lay under the whole pad.
        """
        no_film = self.no_film_texts(factors)
        if self.film is None:
            return [text or FILM_UNKNOWN_TEXT for text in no_film]
        film = Film(
            self.film.gas,
            Actuator(self.film.frequency_hz, 1.0, profile=Piston()),
            Pad(
                length_x_m=self.film.pad.length_x_m,
                length_y_m=self.film.pad.length_y_m,
                gap=self.film.pad.gap,
                speed_x_m_per_s=0.0,
            ),
        )
        centre = np.zeros(len(factors))
        limits = validity_texts(film.scenes(factors.h0_m, factors.hv_m, centre, centre))
        if self.film.surface is None:
            limits[(limits == OK) & self._outside_positions_mask(factors)] = SURFACE_UNKNOWN_TEXT
        return [text or limit for text, limit in zip(no_film, limits, strict=True)]

    def _outside_positions_mask(self, factors: Factors) -> NDArray[np.bool_]:
        """Return which points lie off the positions of the simulations, shape (n,)."""
        known = self.prediction_interval.ranges if self.prediction_interval else self.ranges
        ranges = {name: known.get(name, (0.0, 0.0)) for name in self.position_columns}
        masks = self.folded_factors(factors).outside_masks(ranges)
        return np.any([*masks.values()], axis=0)

    def validation(self, factors: Factors, force_n: ArrayLike) -> tuple[Array, Array, list[str]]:
        """Errors that hold 95 % and 99 % of new points, and why a point is not validated.

        Args:
            force_n: the model's forces at the points, shape (n,).

        Returns both half widths in newtons, shape (n,), NaN where there is none, and notes: why
        there is none, or where the interval holds few points.
        """
        force, interval = np.asarray(force_n, dtype=float), self.prediction_interval
        error_95, error_99 = np.full((2, len(force)), np.nan)
        reasons = [
            "" if known else reason
            for known, reason in zip(np.isfinite(force), self.undefined_texts(factors), strict=True)
        ]
        if interval is None:
            no_sample = f"not validated: {NO_VALIDATION_SAMPLE_TEXT}"
            notes = ["; ".join(filter(None, (no_sample, reason))) for reason in reasons]
            return error_95, error_99, notes
        few = "" if interval.error_95 else "too few points of the sample have a force"
        notes = [
            "; ".join(filter(None, (outside or few, reason)))
            for outside, reason in zip(interval.range_notes(factors), reasons, strict=True)
        ]
        known = [not note for note in notes]
        error_95[known] = interval.error_n(force[known])
        error_99[known] = interval.error_n(force[known], level=0.99)
        texts = [
            f"not validated: {note}" if note else coverage
            for note, coverage in zip(notes, interval.coverage_notes(factors), strict=True)
        ]
        return error_95, error_99, texts

    def undefined_texts(self, factors: Factors) -> list[str]:
        """Reasons for which a model has no force: its table ends, or its formula has no value."""
        texts = np.full(len(factors), "the formula has no value here", dtype=object)
        if self.force_model.column_names and (table := self.limit_table):
            for name, outside in reversed(table.outside_masks(factors).items()):
                texts[outside] = f"the table of the expansion ends at {table.limits_text(name)}"
        return list(texts)

    @property
    def statement(self) -> str:
        """A sentence about the model's error."""
        return (
            f"Not validated: {NO_VALIDATION_SAMPLE_TEXT}."
            if self.prediction_interval is None
            else self.prediction_interval.statement
        )

    def error_percent_columns(self, error_95_n: ArrayLike, force_n: ArrayLike) -> dict[str, Any]:
        """The 95 % error in per cent of the force; with a scan also its two parts."""
        with np.errstate(divide="ignore", invalid="ignore"):
            percent = 100 * np.asarray(error_95_n) / np.abs(force_n)
        scan = 100 * self.profile_uncertainty
        parts = {
            "error_95_without_scan_percent": percent - scan,
            "profile_uncertainty_percent": np.where(np.isfinite(force_n), scan, np.nan),
        }
        return {"error_95_percent": percent} | (parts if scan else {})


def read_fit(path: Path | str) -> FittedModel:
    """Read a fit.

    Raises InputError naming the file and the entry that is missing or wrong, and for a file of
    another version.
    """
    if Path(path).suffix in (".csv", ".html", ".parquet", ".yaml"):
        raise InputError(f"{path}: not a fit; give a file such as models/four_factor/limit_1.json")
    values = read_json(path)
    lacking = [part for part in ("format", *REQUIRED_KEYS) if part not in values]
    if "not_supported" not in values and (lacking or values["format"] != FIT_FILE_FORMAT_VERSION):
        what = f"it lacks {', '.join(lacking)}" if lacking else f"its is {values['format']}"
        raise InputError(
            f"{path}: this version reads fits of format {FIT_FILE_FORMAT_VERSION}, and {what}; fit "
            "again with this version (`squeezefilm fit`, or snakemake for a study)"
        )
    return fit_from_values(values, source=path)


def fit_from_values(values: Mapping[str, Any], *, source: Path | str) -> FittedModel:
    """A fit from what its file holds; ``source`` is the file, for messages.

    Raises InputError naming the place and the entry that is missing or wrong.
    """
    if "not_supported" in values:
        raise InputError(f"{source}: there is no fit: {values['not_supported']}")
    try:
        # Of the film a file has names with units, which are keys of a study without.
        given = {**values, "file": str(source)}
        return FittedModel.model_validate(given, by_alias=True, by_name=True)
    except ValidationError as error:
        wrong = [
            f"{'.'.join(map(str, problem['loc']))}: {problem['msg']}" for problem in error.errors()
        ]
        raise InputError(f"{source}: {'; '.join(wrong)}") from None


def amplitude_row(fit: FittedModel, point: Factors, *, force_n: float) -> dict[str, object]:
    """Amplitude, its errors and a note for one gap and position; NaN where there is none.

    Raises InputError for a target force that is zero or not finite.
    """
    _check_target_force(force_n)
    (no_film,), point = fit.no_film_texts(point), fit.folded_factors(point)
    where = {name: float(point.column(name)[0]) for name in ("h0_m", *point.position_columns)}
    row: dict[str, object] = {
        "force_n": force_n,
        **dict.fromkeys(("hv_m", "hv_error_95_m"), np.nan),
        **fit.error_percent_columns(np.nan, force_n),
        "validity": no_film,
        "note": "",
    }
    if no_film:
        return row
    fit.with_asymptotic_forces(point)  # an error names what is missing, if anything
    try:
        hv_m = amplitude_for_force(fit.evaluate, force_n=force_n, **where)
    except InputError as error:
        note = str(error).removeprefix("force_n: ")
        if not fit.limit_table:
            return row | {"note": note}
        rest_and_contact = Factors.of(**where, hv_m=[0.0, np.nextafter(where["h0_m"], 0.0)])
        undefined = np.flatnonzero(~np.isfinite(fit.evaluate(rest_and_contact)))
        table_ends = [fit.undefined_texts(rest_and_contact)[at] for at in undefined[:1]]
        # Without a force at rest the table has none at this gap, so that no amplitude was tried.
        return row | {"note": "; ".join([note] * (0 not in undefined) + table_ends)}
    near = Factors.of(
        **where
        | {
            "hv_m": hv_m
            * np.array([1 - AMPLITUDE_DIFFERENCE_STEP, 1.0, 1 + AMPLITUDE_DIFFERENCE_STEP])
        }
    )
    below, _, above = fit.evaluate(near)
    slope = (above - below) / (2 * AMPLITUDE_DIFFERENCE_STEP * hv_m) if hv_m else np.nan
    (error_n,), _, (note,) = fit.validation(near.take([1]), [force_n])
    return row | {
        "hv_m": hv_m,
        "hv_error_95_m": error_n / abs(slope) if slope else np.nan,
        **fit.error_percent_columns(error_n, force_n),
        "validity": fit.validity(near.take([1]))[0],
        "note": note,
    }


def amplitude_for_force(
    evaluate: Callable[[Factors], Array], *, force_n: float, h0_m: float, **position: float
) -> float:
    """Smallest amplitude hv in metres that gives the target force at a gap and position.

    ``evaluate`` gives a model's forces in newtons, the position is as Factors.of takes it. A model
    may reach any force just before the edge of the region in which it is defined: beyond it the
    force counts as on the other side of the wanted one, so that a bracket may end there.
    Raises InputError for a force that is zero or not finite, and where no amplitude between rest
    and contact (0 <= hv < h0) gives the force.
    """
    _check_target_force(force_n)

    def excess_force_n(amplitude_ratio: ArrayLike) -> Array:
        at = Factors.of(h0_m=h0_m, hv_m=np.asarray(amplitude_ratio) * h0_m, **position)
        return evaluate(at) - force_n

    def finite_excess_force_n(amplitude_ratio: float, beyond: float) -> float:
        return float(np.nan_to_num(excess_force_n(amplitude_ratio)[0], nan=beyond))

    grid = np.append(
        np.linspace(0.0, 1.0, TRIAL_AMPLITUDE_COUNT, endpoint=False), np.nextafter(1.0, 0.0)
    )
    values = excess_force_n(grid)
    known = ~np.isnan(values)
    changes = (values[:-1] * values[1:] <= 0) | (known[:-1] != known[1:])
    for interval in np.flatnonzero(changes):
        defined = interval if known[interval] else interval + 1
        amplitude_ratio = grid[defined]
        if values[defined]:
            ends = grid[interval : interval + 2]
            amplitude_ratio = scipy.optimize.brentq(
                finite_excess_force_n, *ends, args=(-values[defined],), xtol=1e-16, rtol=1e-15
            )
        # The sign may change at a pole or at the edge, too.
        if abs(excess_force_n(amplitude_ratio)[0]) <= 1e-9 * (1 + abs(force_n)):
            return float(amplitude_ratio) * h0_m
    if not known.any():
        raise InputError(f"force_n: the model has no value at h0 = {1e6 * h0_m:g} µm")
    low, high = 1e6 * h0_m * grid[known][[0, -1]]
    amplitudes = "all hv below contact" if known.all() else f"hv from {low:.3g} to {high:.3g} µm"
    least, largest = np.min(values[known]) + force_n, np.max(values[known]) + force_n
    raise InputError(
        f"force_n: the model gives {least:.3g} to {largest:.3g} N at h0 = {1e6 * h0_m:g} µm for "
        f"{amplitudes}, not {force_n:g} N"
    )


def _check_target_force(force_n: float) -> None:
    if not np.isfinite(force_n) or force_n == 0:
        raise InputError(f"force_n: {force_n:g} N must be finite and not zero")

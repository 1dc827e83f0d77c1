"""A whole study: the film, the plans of its simulations, and the models fitted to them.

What follows from other keys where it is not written is filled in once all keys are valid
(``Study.with_derived_values``), then relations between keys are checked.
"""

from math import cos, floor, hypot, log10, radians, sin
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, StrictBool, model_validator

from squeezefilm.config.film import FilmSections
from squeezefilm.film.pad import Pad
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS, Positions
from squeezefilm.film.profiles import TravellingWave
from squeezefilm.sections import (
    DERIVED_DEFAULT,
    BoundedNumber,
    Section,
    Text,
    UniqueItems,
    error_at_key,
    key_of_name,
)

ERROR_MAP_LEVELS_RATIO, MAX_ERROR_MAP_LEVELS = 2, 1000
"""The error map's levels over the screen's: they share no points but the corners."""
EQUAL_LEVELS_TOLERANCE = RANGE_ROUNDING_TOLERANCE = 1e-9
DEFAULT_DIRECTIONS_DEG = (0.0, 22.5, 45.0)
DEFAULT_POSITION_COUNT = 25
"""Of the four-factor plan, where they are to fill the reachable space."""
DEFAULT_EXTRAPOLATION_RATIO, MAX_EXTRAPOLATION_RATIO = 1.1, 1.5
"""An amplitude beyond the screen at which its models are tried, over the screen's largest: the
default, and the most."""

GapOrAmplitude = Annotated[
    float, BoundedNumber("m", 1e-9, 1e-3)
]  # below a nanometre there is no film of gas
Separation = Annotated[float, BoundedNumber("1", 0, 0.5, open=True)]
Count = Annotated[int, Field(strict=True, ge=1, le=1000)]
Seed = Annotated[int, Field(strict=True, ge=0, le=10**9)]
ModelName = Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,39}$")]
LengthOneTo100 = Field(min_length=1, max_length=100)
ModelNames = Annotated[list[ModelName], LengthOneTo100, UniqueItems]


class Simulation(Section):
    """Division of the work into jobs.

    Attributes:
        seconds_per_job: the simulations of a plan are divided into jobs of about so many seconds of
            solving on one thread, by an estimate of what its scenes cost. A job's start takes one
            to two seconds, on a cluster more. Forces do not depend on it
    """

    seconds_per_job: Annotated[float, BoundedNumber("s", 1e-6, 1e6)] = 10.0


class Sweep(Section):
    """`snakemake sweep`: many points, evenly over the box of all four factors.

    Attributes:
        points: how many
        first: how many points of the sequence to skip: sweeps with `first` 0, 1000, 2000 … and
            1000 `points` each are one sweep in parts, each a separate study
        seed: of the sequence's scrambling; the same for all parts
    """

    points: Annotated[int, Field(strict=True, ge=1, le=10**7)] = 1000
    first: Seed = 0
    seed: Seed = 1


class Levels(Section):
    """Evenly spaced values.

    Attributes:
        start: the first
        stop: the last
        levels: how many
    """

    start: GapOrAmplitude
    stop: GapOrAmplitude
    levels: Annotated[int, Field(strict=True, ge=2, le=MAX_ERROR_MAP_LEVELS)] = 8


class Screen(Section):
    """The first plan: every gap with every amplitude, pad centred.

    Attributes:
        h0_m: mean gaps: `levels` values, evenly spaced from `start` to `stop`. This range and that
            of `hv` are the space of every plan: designs, control points, `error_map`, `refine`,
            `sweep`
        hv_m: amplitudes at the profile's maximum, likewise; the largest must stay below the
            smallest gap
    """

    h0_m: Levels
    hv_m: Levels


class SeedCounts(Section):
    """Runs per bound.

    Attributes:
        two_factor: for models of gap and amplitude alone
        four_factor: for models that contain the pad's position
    """

    two_factor: Count = 4
    four_factor: Count = 1


class Fit(Section):
    """A genetic algorithm, then Nelder–Mead, from many seeds.

    Attributes:
        bounds: largest magnitudes of a parameter in the search, of those in which the force is not
            linear; every fit is made with each. A fit with wider bounds checks them: where its sum
            of squares is much smaller it is taken, and a note states so
        first_seed: seed of the first run; the others count up from it
    """

    bounds: Annotated[
        list[Annotated[float, BoundedNumber("1", 0, 1e12, open=True)]],
        Field(min_length=1, max_length=10),
        UniqueItems,
    ] = Field(default=[100.0])
    seeds: SeedCounts = Field(default_factory=SeedCounts)
    first_seed: Seed = 1


class Design(Section):
    """D-optimal triplets of the two-factor model, criterion (12).

    Attributes:
        searches: how many searches, each with a different seed
        first_seed: seed of the first search; the others count up from it
        scaling: in which measure the distances of (12) are taken for the design that is used:
            `unit` (factors scaled to [0, 1]), `micrometre`, `metre`. All three are searched and
            reported
        points: size of the design: the union of the patterns found, extended to this number
    """

    searches: Count = 5
    first_seed: Seed = 1
    scaling: Literal["unit", "micrometre", "metre"] = "unit"
    points: Annotated[int, Field(strict=True, ge=3, le=100)] = 5


class FourFactorDesign(Section):
    """D-optimal points of the four-factor model.

    Attributes:
        searches: how many searches, each with a different seed
        first_seed: seed of the first search; the others count up from it
        separation: least distance between two points of the physically distinct form, all factors
            scaled to 1
    """

    searches: Count = 2
    first_seed: Seed = 1
    separation: Separation = 0.25


class FourFactorControl(Section):
    """Random points of the four-factor space, on which the paper's fits are validated.

    Attributes:
        points: how many
        seed: of their draw
    """

    points: Annotated[int, Field(strict=True, ge=1, le=10**6)] = 20
    seed: Seed = 1


class ErrorMapLevels(Section):
    """Evenly spaced values, over the screen's range where nothing else is written.

    Attributes:
        start: the first; default: the screen's
        stop: the last; default: the screen's
        levels: how many; default: twice the screen's
    """

    start: GapOrAmplitude = DERIVED_DEFAULT
    stop: GapOrAmplitude = DERIVED_DEFAULT
    levels: Annotated[int, Field(strict=True, ge=2, le=MAX_ERROR_MAP_LEVELS)] = DERIVED_DEFAULT


class ErrorMap(Section):
    """Control simulations, a finer grid of gaps and amplitudes over the screen's ranges.

    Attributes:
        h0_m: mean gaps over the screen's range; with `start` or `stop` a part of it
        hv_m: amplitudes, likewise
    """

    h0_m: ErrorMapLevels = Field(default_factory=ErrorMapLevels)
    hv_m: ErrorMapLevels = Field(default_factory=ErrorMapLevels)


UnitText = Annotated[str, Field(min_length=1, max_length=40)]


class OwnModel(Section):
    """A formula of your own for the force.

    Attributes:
        expression: the formula: the mean force in newtons
        about: what it is, in words, for tables
        parameters: its parameters, unless they are called `t0`, `t1`, …: a list, or a mapping to
            their units
        constants: names of numbers with their units, such as `{wavelength: 12 mm}`
    """

    expression: Annotated[str, Field(min_length=1, max_length=4000)]
    about: Annotated[str, Field(max_length=200)] = DERIVED_DEFAULT
    parameters: (
        Annotated[list[UnitText], Field(max_length=30), UniqueItems]
        | Annotated[dict[str, UnitText | Literal[1]], Field(max_length=30)]
    ) = DERIVED_DEFAULT
    constants: dict[str, str | float] = Field({}, max_length=30)


class ModelNamesBySpace(Section):
    """Names of models for each space of factors."""

    two_factor: ModelNames = DERIVED_DEFAULT
    four_factor: ModelNames = DERIVED_DEFAULT

    def names_of_space(self, space: str) -> list[str]:
        """The models of a space, ``two_factor`` or ``four_factor``."""
        return {"two_factor": self.two_factor, "four_factor": self.four_factor}[space]

    @property
    def all_names(self) -> list[str]:
        """The models of both spaces."""
        return [*self.two_factor, *self.four_factor]


class Comparison(ModelNamesBySpace):
    """Candidates that `snakemake models` compares, by the names of your own or of the library
    (workflow/squeezefilm/models/models.yaml).

    Attributes:
        two_factor: those fitted to the screen, the pad centred, and ranked on half of the
            validation sample; default: the usual ones; for a flat rectangle those of the
            asymptotic expansion where it is known for its gas
        four_factor: those fitted to the four-factor plan, likewise; default: likewise
    """


class Refine(ModelNamesBySpace):
    """`snakemake refine`: simulate, fit, design, until a model is good enough (see
    docs/how-to/few-simulations.md).

    Attributes:
        two_factor: models to refine with the pad centred: the library's or the study's own;
            default: `limit_1`, or `polynomial_3` where no model of the asymptotic expansion is
            compared by default
        four_factor: models to refine with the pad anywhere; default: `limit_2`, or
            `polynomial_5`
        global_error: target of |model − simulation|/|simulation| over the space, for its upper
            95 % limit
        worst_error: target of the largest error, over the root mean square force of the space
        simulations: most simulations, verification included
        verification: of these, points drawn from the space that are never fitted
        batch: points designed in each round
        candidates: most points of the grid that designs are chosen from
        separation: least distance of two points, all factors scaled to 1
        seed: of the verification points, and of the search of the first fit
    """

    global_error: Annotated[float, BoundedNumber("1", 0, 1, open=True)] = 1e-3
    worst_error: Annotated[float, BoundedNumber("1", 0, 10, open=True)] = 5e-3
    simulations: Annotated[int, Field(strict=True, ge=3, le=10000)] = 20
    verification: Annotated[int, Field(strict=True, ge=3, le=1000)] = 8
    batch: Count = 2
    candidates: Annotated[int, Field(strict=True, ge=16, le=20000)] = 300
    separation: Separation = 0.1
    seed: Seed = 1


class OptimalDesigns(Section):
    """`snakemake optimal`: D-optimal designs with bounds of their efficiency.

    Attributes:
        candidates: most points of the grid that designs are chosen from
        points: sizes of the exact designs
        separation: least distance of two points, all factors scaled to 1
        seed: of the search
    """

    candidates: Annotated[int, Field(strict=True, ge=16, le=100000)] = 300
    points: Annotated[
        list[Annotated[int, Field(strict=True, ge=1, le=200)]],
        Field(min_length=1, max_length=20),
        UniqueItems,
    ] = Field(default=[5, 8])
    separation: Separation = 0.1
    seed: Seed = 1


class Validation(Section):
    """Samples of independent points that validate fitted models, uniform over the declared
    space, one with the pad centred and one over all factors.

    Attributes:
        points: of each sample; one half ranks models, the other calibrates their prediction
            intervals (95 % needs 38 points altogether, 99 % 198)
        seed: of their draw
        relative_error_band: relative error up to which a model counts as good, 0.15 in the paper
    """

    points: Annotated[int, Field(strict=True, ge=2, le=10**6)] = 1000
    seed: Seed = 2
    relative_error_band: Annotated[float, BoundedNumber("1", 0, 1, open=True)] = 0.15


class Extrapolation(Section):
    """The target force, and an operating point beyond the screen that checks the models.

    Attributes:
        h0_m: mean gap of the operating point that is simulated, within the screen's range; default:
            the screen's smallest gap
        hv_m: its amplitude, up to 1.5 times the screen's largest; default: 1.1 times the screen's
            largest amplitude; that itself where 1.1 times it reaches the gap
        force_n: the target force: each model gives an amplitude for it at `h0`, and a simulation
            checks it
    """

    h0_m: GapOrAmplitude = DERIVED_DEFAULT
    hv_m: GapOrAmplitude = DERIVED_DEFAULT
    force_n: Annotated[float, BoundedNumber("N", 0, 1e6, open=True)]


class NumericsVerification(Section):
    """The solver examined, `snakemake verification` (see docs/verification.md).

    Attributes:
        extent: `full`, or a `sample` of its films, methods and cases
        repeats: how often a short run is timed; the median counts
        longest_seconds: a method is refined until a run takes longer than this
    """

    extent: Literal["full", "sample"] = "sample"
    repeats: Count = 1
    longest_seconds: Annotated[float, BoundedNumber("s", 0, 1e5, open=True)] = 0.2


class Figures(Section):
    """Look of the figures.

    Attributes:
        style: a style file of matplotlib (`.mplstyle`), from the folder of this file: fonts, sizes
            and lines; colours that carry a meaning stay
    """

    style: Text = DERIVED_DEFAULT


class Measurements(Section):
    """`snakemake measurements`: your own measured forces beside computed ones.

    Attributes:
        file: a table (CSV, from the folder of this file) with the columns `h0 [µm]`, `hv [µm]`, a
            position unless the pad is centred, `force [mN]` and `force uncertainty [mN]`, each in
            any unit; and, where they are known, `h0 uncertainty [µm]` and `hv uncertainty [µm]`.
            Uncertainties are standard ones
    """

    file: Text


class StudyHeader(Section):
    """First keys of a study."""

    study: Annotated[str, Field(pattern="^[a-z0-9][a-z0-9_-]{0,59}$")]
    paper: StrictBool = False


class Study(FilmSections, StudyHeader):
    """A study – gas, actuator, pad, and what is simulated, fitted and designed.

    Attributes:
        study: name of the study: lower-case letters, digits, `_`, `-`. Its results lie in
            `results/STUDY`
        paper: `true` for studies of the paper's actuator: its claims, tables and figures are made
            beside the study's own
        models: formulas of your own for the force, each under a name (docs/reference/formulas.md)
    """

    simulation: Simulation = Field(default_factory=Simulation)
    sweep: Sweep = Field(default_factory=Sweep)
    screen: Screen
    fit: Fit = Field(default_factory=Fit)
    design: Design = Field(default_factory=Design)
    positions: Positions = Field(default_factory=Positions)
    four_factor_design: FourFactorDesign = Field(default_factory=FourFactorDesign)
    four_factor_control: FourFactorControl = Field(default_factory=FourFactorControl)
    error_map: ErrorMap = Field(default_factory=ErrorMap)
    models: Annotated[dict[ModelName, OwnModel], Field(max_length=100)] = Field(default={})
    comparison: Comparison = Field(default_factory=Comparison)
    refine: Refine = Field(default_factory=Refine)
    optimal: OptimalDesigns = Field(default_factory=OptimalDesigns)
    validation: Validation = Field(default_factory=Validation)
    extrapolation: Extrapolation
    numerics: NumericsVerification = Field(default_factory=NumericsVerification)
    figures: Figures = Field(default_factory=Figures)
    measurements: Measurements = DERIVED_DEFAULT

    @model_validator(mode="after")
    def with_derived_values(self) -> "Study":
        """The study with what follows from the rest, its relations checked."""
        self._derive_plans()
        self._derive_models()
        self._derive_positions()
        self._check_ranges()
        self._check_positions()
        return self

    def _derive_plans(self) -> None:
        """The ranges of the error map and the extrapolation, from the screen's."""
        for factor in ("h0_m", "hv_m"):
            fitted, control = getattr(self.screen, factor), getattr(self.error_map, factor)
            levels = min(ERROR_MAP_LEVELS_RATIO * fitted.levels, MAX_ERROR_MAP_LEVELS)
            _set_missing_values(control, start=fitted.start, stop=fitted.stop, levels=levels)
        wanted, largest_m = self.extrapolation, self.screen.hv_m.stop
        _set_missing_values(wanted, h0_m=self.screen.h0_m.start)
        farther_m = float(f"{DEFAULT_EXTRAPOLATION_RATIO * largest_m:.12g}")
        _set_missing_values(wanted, hv_m=largest_m if farther_m >= wanted.h0_m else farther_m)

    def _derive_models(self) -> None:
        """The models that are compared and refined: the limit's for flat rectangles at rest.

        With inertia, which is `auto` by default, it is derived for a flat gap alone.
        """
        pad, gas, profile = self.pad, self.gas, self.actuator.profile
        one_phase = not isinstance(profile, TravellingWave)
        one_phase &= getattr(profile, "quadrature", "0") == "0"
        known = (
            pad.shape == "rectangle"
            and pad.speed_x_m_per_s == 0
            and pad.gap.flat
            and (one_phase or gas.inertia == "none")
            and gas.rarefaction == "none"
            and gas.polytropic_exponent == 1
            and gas.thermal != "included"
        )
        physics = ["limit", "limit_1", "limit_2"] if known else []
        _set_missing_values(
            self.comparison,
            two_factor=["two_factor", "polynomial_3", *physics[:2]],
            four_factor=["four_factor", "polynomial_5", *physics],
        )
        best = ("limit_1", "limit_2") if known else ("polynomial_3", "polynomial_5")
        _set_missing_values(self.refine, two_factor=[best[0]], four_factor=[best[1]])

    def _derive_positions(self) -> None:
        """Positions in the form of the surface: half of the way that the pad may go, and all."""
        positions, surface = self.positions, self.actuator.rectangle
        if not (self.paper or positions.model_fields_set):
            positions.points = DEFAULT_POSITION_COUNT
        if surface is None:
            _set_missing_values(positions, phi_deg=list(DEFAULT_DIRECTIONS_DEG))
            if positions.phi_r_m is None:
                half_m, reach_m = self.actuator.surface_radius_m, _farthest_edge_m(self.pad)
                way_m = _max_travel_m(self.pad, reach_m, "actuator.surface_radius", half_m)
                positions.phi_r_m = [_round_down_3_digits(way_m / 2), _round_down_3_digits(way_m)]
            return
        for axis, reach_m in zip("xy", _half_extents_along_axes_m(self.pad), strict=True):
            if getattr(positions, f"{axis}_m") is None:
                half_m = getattr(surface, f"length_{axis}_m") / 2
                key = f"actuator.surface.length_{axis}"
                way_m = _max_travel_m(self.pad, reach_m, key, half_m, along=f" along {axis}")
                setattr(
                    positions,
                    f"{axis}_m",
                    [0.0, _round_down_3_digits(way_m / 2), _round_down_3_digits(way_m)],
                )

    def _check_ranges(self) -> None:
        """Reject empty ranges, and values outside the screen's, where models are fitted.

        An extrapolation may lie above them in amplitude, up to MAX_EXTRAPOLATION_RATIO times
        the largest; an error map must have points that the screen has not.
        """
        new = False
        for factor, farthest in (("h0_m", 1.0), ("hv_m", MAX_EXTRAPOLATION_RATIO)):
            key = key_of_name(factor)
            fitted, control, wanted_m = (
                getattr(section, factor)
                for section in (self.screen, self.error_map, self.extrapolation)
            )
            for section, levels in (("screen", fitted), ("error_map", control)):
                if levels.start >= levels.stop:
                    raise error_at_key("start must be below stop", section, key)
            for key_path, value, most in (
                (("error_map", key, "start"), control.start, fitted.stop),
                (("error_map", key, "stop"), control.stop, fitted.stop),
                (("extrapolation", key), wanted_m, farthest * fitted.stop),
            ):
                if (
                    not fitted.start * (1 - RANGE_ROUNDING_TOLERANCE)
                    <= value
                    <= most * (1 + RANGE_ROUNDING_TOLERANCE)
                ):
                    raise error_at_key(
                        f"{value:g} does not suit screen.{key}, {fitted.start:g} … "
                        f"{fitted.stop:g}, where the models are fitted; it must lie from "
                        f"{fitted.start:g} to {most:g}",
                        *key_path,
                    )
            screen = np.linspace(fitted.start, fitted.stop, fitted.levels)
            finer = np.linspace(control.start, control.stop, control.levels)
            new |= (
                not np.isclose(finer[:, None], screen, rtol=EQUAL_LEVELS_TOLERANCE, atol=0)
                .any(axis=1)
                .all()
            )
        if not new:
            raise error_at_key(
                "all its points are the screen's, and no model can be judged by points that it was "
                "fitted to; give other levels, or leave error_map out to have twice the screen's",
                "error_map",
            )

    def _check_positions(self) -> None:
        """Reject positions in a form that is not the surface's."""
        disc, positions = self.actuator.rectangle is None, self.positions
        factors, shape = (POLAR_COLUMNS, "disc") if disc else (CARTESIAN_COLUMNS, "rectangle")
        written = [
            name
            for name in (*POLAR_COLUMNS, *CARTESIAN_COLUMNS)
            if getattr(positions, name) is not None
        ]
        if written != [*factors]:
            raise error_at_key(
                f"on a {shape} they are {' and '.join(map(key_of_name, factors))}; "
                f"the keys are {', '.join(map(key_of_name, written))}",
                "positions",
            )
        for factor in () if disc else factors:
            if max(getattr(positions, factor)) <= 0:
                raise error_at_key(
                    "a value must be above 0: the pad moves in x and y",
                    *("positions", key_of_name(factor)),
                )
        if not disc and self.paper:
            raise error_at_key("the paper's actuator is a disc; it must be false", "paper")


def _set_missing_values(section: Section, **values: Any) -> None:
    """Give a section's keys their values where nothing is written."""
    for name, value in values.items():
        if getattr(section, name) is None:
            setattr(section, name, value)


def _farthest_edge_m(pad: Pad) -> float:
    """Largest distance of a pad's edge from its centre."""
    half_x, half_y = pad.length_x_m / 2, pad.length_y_m / 2
    return max(half_x, half_y) if pad.shape == "ellipse" else hypot(half_x, half_y)


def _half_extents_along_axes_m(pad: Pad) -> tuple[float, float]:
    """Extent of a pad from its centre along the surface's axes."""
    half_x, half_y = pad.length_x_m / 2, pad.length_y_m / 2
    angle = radians(pad.rotation_deg)
    c, s = abs(cos(angle)), abs(sin(angle))
    if pad.shape == "ellipse":
        return hypot(c * half_x, s * half_y), hypot(s * half_x, c * half_y)
    return c * half_x + s * half_y, s * half_x + c * half_y


def _max_travel_m(
    pad: Pad, reach_m: float, surface_key: str, half_m: float, *, along: str = ""
) -> float:
    """Largest distance that the pad may move one way, by its reach and half the surface's."""
    if half_m - reach_m <= 1e-6 * reach_m:
        # Of a curve whose points are not read yet the reach is an upper bound.
        otherwise = ", or write the positions" if pad.shape == "curve" else ""
        raise error_at_key(
            f"it reaches {reach_m * 1e3:.4g} mm from its centre{along}, and the surface "
            f"{half_m * 1e3:.4g} mm ({surface_key}): there is no room to move the pad, as the "
            f"four-factor plan does; give a smaller pad or a larger surface{otherwise}",
            "pad",
        )
    return half_m - reach_m


def _round_down_3_digits(value: float) -> float:
    """A little less than the value, in three digits."""
    step = 10.0 ** (floor(log10(value)) - 2)
    return float(f"{floor(value * (1 - 1e-9) / step) * step:.3g}")

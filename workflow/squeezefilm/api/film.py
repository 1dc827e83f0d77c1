"""A film of gas between a vibrating surface and a pad: forces, curves, pressure fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import isfinite, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np

from squeezefilm.api.forces import Force, forces_table, solve_forces
from squeezefilm.config.film import FilmSections
from squeezefilm.config.loading import load_film, validated_sections
from squeezefilm.errors import InputError, RunError, imports_from_extra
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.validity import OK
from squeezefilm.lazy import pd
from squeezefilm.quantities.pressure import gauge_pressure_and_change
from squeezefilm.reynolds.device import Device
from squeezefilm.studies.solver_settings import SolverSettings, solver_settings
from squeezefilm.studies.study import scenes_of_table
from squeezefilm.tables import FACTOR_COLUMNS, normalise_points
from squeezefilm.text_tables.cells import number_of_cell
from squeezefilm.units import parse_quantities

if TYPE_CHECKING:
    import xarray

    from squeezefilm.api.points import Points
    from squeezefilm.film.measured.smooth import SmoothedScan

FactorValues = str | float | Sequence[float] | np.ndarray
"""Values of one factor: a number in SI units (degrees for angles), several of them, or a text with
units such as ``"5 um"``, ``"5 um, 6 um"``, ``"0.5:2.5:9 um"`` (first:last:count)."""
COLUMN_OF_FACTOR = {
    "h0": "h0_m",
    "hv": "hv_m",
    "x": "x_m",
    "y": "y_m",
    "phi_r": "phi_r_m",
    "phi": "phi_deg",
}
"""What the factors are called where they are asked for, and their columns."""
MAX_POINT_COUNT = 1_000_000


class Position(TypedDict, total=False):
    """The pad's centre from the actuator's: Cartesian, or polar with phi in degrees."""

    x: FactorValues | None
    y: FactorValues | None
    phi_r: FactorValues | None
    phi: FactorValues | None


def factor_combinations(
    *, option: str = "{}", **given: FactorValues | None
) -> dict[str, tuple[float, ...]]:
    """Every combination of the values given, a column for each factor given.

    Args:
        option: how a factor's name is written in messages.
        given: by the names in COLUMN_OF_FACTOR.

    Raises InputError for a value without its unit or no finite number, for a position in both
    forms, for too many points.
    """
    if unknown := given.keys() - COLUMN_OF_FACTOR.keys():
        raise TypeError(
            f"{min(unknown)!r} is no argument and none of the factors {', '.join(COLUMN_OF_FACTOR)}"
        )
    called = {name: option.format(name.replace("_", "-")) for name in COLUMN_OF_FACTOR}
    values_of = {
        column: parse_factor_values(
            values, called=called[name], unit="deg" if name == "phi" else "m"
        )
        for name, column in COLUMN_OF_FACTOR.items()
        if (values := given.get(name)) is not None
    }
    if values_of.keys() & {*CARTESIAN_COLUMNS} and values_of.keys() & {*POLAR_COLUMNS}:
        message = "give the position as {x} and {y} or as {phi_r} and {phi}, not both"
        raise InputError(message.format(**called))
    if "phi_deg" in values_of and "phi_r_m" not in values_of:
        message = "{phi} is a direction; give the distance from the centre by {phi_r} too"
        raise InputError(message.format(**called))
    if (count := prod(map(len, values_of.values()))) > MAX_POINT_COUNT:
        raise InputError(f"these make {count} points; at most {MAX_POINT_COUNT} are allowed")
    return dict(zip(values_of, zip(*product(*values_of.values()), strict=True), strict=False))


def points_of_factors(*, option: str = "{}", **given: FactorValues | None) -> Points:
    """Every combination as a table of Points, to which forces can be added as columns."""
    from squeezefilm.api.points import Points

    return Points(factor_combinations(option=option, **given), dtype=float)


def parse_factor_values(values: FactorValues, *, called: str, unit: str) -> list[float]:
    """The numbers that are meant, in SI units or degrees.

    Raises InputError naming what they are called.
    """
    if isinstance(values, str):
        return parse_quantities(values, option=called, unit=unit)
    numbers = [number_of_cell(value) for value in np.ravel(np.asarray(values, dtype=object))]
    if not numbers or not np.isfinite(numbers).all():
        raise InputError(
            f"{called}: {values!r} is no finite number in {unit}, nor several of them, nor a text "
            "with units"
        )
    return numbers


POINTS_PER_SIDE_RANGE, TIME_POINTS_RANGE = (3, 1001), (4, 1024)
"""The least and most of a pressure field, along a side and over a period."""
UNIT_AND_LABEL_OF_VARIABLE = {
    "gauge_pressure": ("Pa", "gauge pressure"),
    "gap": ("m", "gap between surface and pad"),
    "phase": ("degree", "phase"),
    "y": ("m", "y from the pad's centre"),
    "x": ("m", "x from the pad's centre"),
    "time": ("s", "time"),
}
PRESSURE_TOLERANCE = 1e-4
"""Of the largest gauge pressure, where none is given."""


@dataclass(frozen=True, repr=False)
class Film:
    """A gas, an actuator and a pad; calls give gap, amplitude and the pad's position.

    A quantity is a number in SI units or a text with its unit, ``"5 um"``; the position is
    that of the pad's centre from the actuator's, Cartesian (``x``, ``y``) or polar (``phi_r``,
    ``phi`` in degrees), the centre by default.

    Attributes:
        config: the sections ``gas``, ``actuator``, ``pad`` and ``solver`` of a study.
        given_settings: arguments of ``solver_settings`` instead of the study's.
    """

    config: FilmSections
    given_settings: Mapping[str, Any] = field(default_factory=dict)

    @staticmethod
    def of(
        *,
        actuator: Mapping[str, Any],
        pad: Mapping[str, Any],
        gas: Mapping[str, Any] | None = None,
        solver: Mapping[str, Any] | None = None,
    ) -> Film:
        """A film without a file, from the keys of a study's sections.

        The keys of the sections are those of docs/reference/configuration.md, such as ``actuator``:
        frequency, surface_radius, profile; ``pad``: shape, length_x, length_y, speed_x, gap;
        ``gas``: name, inertia, thermal, rarefaction; ``solver``: tolerance, method.

        By default the gas is air at 20 °C, with inertia and thermal effects where they matter, the
        pad a flat rectangle at rest and the relative tolerance 1e-4. The path of a measured
        profile's file is relative to the working directory.
        Raises InputError naming the key, what is wrong with it and what is allowed.

        Example:
            >>> film = Film.of(
            ...     actuator={
            ...         "frequency": "30 kHz",
            ...         "surface_radius": "15 mm",
            ...         "profile": {"kind": "piston"},
            ...     },
            ...     pad={"length_x": "12 mm", "length_y": "9 mm"},
            ... )
        """
        given = {"gas": gas, "actuator": actuator, "pad": pad, "solver": solver}
        sections = {
            name: dict(keys) if isinstance(keys, Mapping) else keys
            for name, keys in given.items()
            if keys is not None
        }
        return Film(validated_sections(sections, path=Path("film"), model=FilmSections))

    @staticmethod
    def read(path: Path | str) -> Film:
        """Read the film of a file, which need not be a study: its plans are not checked.

        Raises InputError as ``of`` does, with file and line.

        Example:
            >>> sf.Film.read("config/levitation.yaml").force(h0="5 um", hv="2 um")
        """
        return Film(load_film(path))

    @property
    def device(self) -> Device:
        """The OpenCL device of the solver, by SQUEEZEFILM_DEVICE or else ``solver.device``.

        Raises InputError where there is none.

        Example:
            >>> study.device.name
        """
        return self.solver().device

    def solver(self, **given: Any) -> SolverSettings:
        """The solver's settings: those given here, to the film, or by the study.

        Example:
            >>> study.solver(tolerance=1e-4).tolerance
        """
        given = {name: value for name, value in given.items() if value is not None}
        return solver_settings(self.config, **{**self.given_settings, **given})

    @property
    def scan(self) -> SmoothedScan | None:
        """The measured mode shape with its noise and notes; None if it is not measured.

        Example:
            >>> study.scan is None  # a formula, not a measured profile
        """
        return self.config.smoothed_scan()

    def scene(self, h0: str | float, hv: str | float, **position: Unpack[Position]) -> Scene:
        """One operating point, with the dimensionless numbers that govern it.

        Raises InputError for a value without meaning or unit, and for a pad off the actuator.

        Example:
            >>> study.scene(h0="5 um", hv="2 um", x="1 mm").sigma
        """
        scenes = self.scenes(factor_combinations(h0=h0, hv=hv, **position))
        if len(scenes) != 1:
            raise InputError(f"one scene is asked for, not {len(scenes)}: `curve` takes several")
        return scenes[0]

    def scenes(self, points: pd.DataFrame | Mapping[str, Sequence[float]]) -> Scenes:
        """The operating points of a table: h0_m, hv_m and a position, if any.

        Columns may have another unit, such as ``h0_um``; results beside them are ignored.
        Raises InputError as ``scene`` does, and for a column that is not known.

        Example:
            >>> len(study.scenes({"h0_m": [5e-6, 6e-6], "hv_m": [2e-6, 2e-6]}))
        """
        return scenes_of_table(self._with_factor_columns(points), self.config)

    @staticmethod
    def _with_factor_columns(points: Any) -> Any:
        """Points with the factors under their own names."""
        return normalise_points(points, needed=FACTOR_COLUMNS[:2])

    def force(
        self,
        h0: str | float,
        hv: str | float,
        *,
        tolerance: float | None = None,
        method: str | None = None,
        outputs: Sequence[str] | None = None,
        derivatives: bool = False,
        **position: Unpack[Position],
    ) -> Force:
        """The mean force at one operating point, with its numerical and modelling error.

        Args:
            tolerance: required relative error; that of the study by default.
            method: solver method (docs/explanation/physics.md); that of the study by default.
            outputs: further quantities (docs/outputs.md), found in ``force.solution.outputs``;
                ``["all"]`` for all; those of the study by default.
            derivatives: whether derivatives with respect to gap, amplitude, position and gas are
                found in ``force.solution.derivatives`` (docs/outputs.md#derivatives).

        Raises InputError as ``scene`` does, RunError saying why there is no force.

        Example:
            >>> force = study.force(h0="5 um", hv="2 um", x="1 mm")
            >>> force.force_n, force.error_n, force.modelling_error_percent
            >>> force = study.force(h0="5 um", hv="2 um", derivatives=True)
            >>> force.solution.derivatives.value["h0_m"]  # N/m, the stiffness with the other sign
        """
        given: dict[str, Any] = {"tolerance": tolerance, "method": method, "outputs": outputs}
        scenes = [self.scene(h0, hv, **position)]
        (force,) = self.solved(scenes, derivatives=derivatives, budget=True, **given)
        if not isfinite(force.force_n):
            beyond = f"; validity: {force.validity}" * (force.validity != OK)
            raise RunError(force.status + beyond)
        return force

    def curve(
        self,
        h0: FactorValues,
        hv: FactorValues,
        *,
        tolerance: float | None = None,
        method: str | None = None,
        outputs: Sequence[str] | None = None,
        derivatives: bool = False,
        budget: bool = False,
        **position: Unpack[Position],
    ) -> pd.DataFrame:
        """The forces at every combination of some gaps, amplitudes and positions, a row for each.

        Several values are a sequence, or a text such as ``"0.5, 1, 2 um"`` or ``"0.5:2.5:9 um"``
        (first:last:count). ``force_error_n`` is the numerical error, ``measurement_noise_n`` what
        a scan adds; ``status`` is ``ok``, or why there is no force. With ``budget``,
        ``modelling_error_lower_percent`` and ``modelling_error_upper_percent`` bound the effects
        that the equation neglects. ``outputs`` and ``derivatives`` are as for a force, each a
        column with its unit and one with its error. Raises InputError as ``scene`` does.

        Example:
            >>> study.curve(h0="5 um, 7 um", hv="0.5:2:4 um")[["h0_m", "hv_m", "force_n"]]
        """
        points = points_of_factors(h0=h0, hv=hv, **position)
        given: dict[str, Any] = {"tolerance": tolerance, "method": method, "outputs": outputs}
        return self.forces(points, derivatives=derivatives, budget=budget, **given)

    def forces(
        self,
        points: pd.DataFrame,
        *,
        tolerance: float | None = None,
        method: str | None = None,
        outputs: Sequence[str] | None = None,
        derivatives: bool = False,
        budget: bool = False,
    ) -> pd.DataFrame:
        """The forces at a table of points: h0_m, hv_m and a position, if any.

        Example:
            >>> study.forces(pd.DataFrame({"h0_m": [5e-6, 6e-6], "hv_m": 2e-6}))["force_n"]
        """
        given: dict[str, Any] = {"tolerance": tolerance, "method": method, "outputs": outputs}
        from squeezefilm.api.points import Points

        points = Points(self._with_factor_columns(points))
        how: dict[str, Any] = {"derivatives": derivatives, "budget": budget, **given}
        return forces_table(points, self.solved(self.scenes(points), **how))

    def solved(
        self,
        scenes: Scenes | Sequence[Scene],
        *,
        derivatives: bool = False,
        budget: bool = False,
        **given: Any,
    ) -> list[Force]:
        """The force of each scene, NaN with its reason as ``status`` where there is none.

        Args:
            derivatives: of each force too, as ``force`` has them.
            budget: the modelling error of each force too.
            given: ``tolerance``, ``method`` and ``outputs``, as ``force`` has them.

        Example:
            >>> [float(force) for force in study.solved([study.scene(h0="5 um", hv="2 um")])]
        """
        how: dict[str, Any] = {"derivatives": derivatives, "budget": budget, "smoothed": self.scan}
        return solve_forces(scenes, settings=self.solver(**given), **how)

    def levitate(
        self,
        hv: FactorValues,
        *,
        load: FactorValues | None = None,
        mass: FactorValues | None = None,
        **position: Unpack[Position],
    ) -> pd.DataFrame:
        """The gap at which the film carries a load, a row for each amplitude, position and load.

        The columns are those of ``squeezefilm levitate``, among them ``h0_m``, its errors, and
        ``stiffness_n_per_m``; ``status`` is ``ok``, or why there is no gap.

        Args:
            load: loads; the weight of each mass by default.
            mass: levitated masses, for resonance and damping ratio too.

        Raises InputError without load and mass, and as ``scene`` does.

        Example:
            >>> film = sf.Film.read("config/levitation.yaml")
            >>> film.levitate("3 um", mass="60 g")[["h0_m", "stiffness_n_per_m", "resonance_hz"]]
        """
        from squeezefilm.api.dynamics import levitation_scenes, levitations, parse_loads
        from squeezefilm.api.points import Points
        from squeezefilm.dynamics.levitation_tables import levitation_table

        loads = parse_loads(load, mass)
        scenes = levitation_scenes(self, factor_combinations(hv=hv, **position))
        return Points(levitation_table(levitations(self, scenes, loads)))

    def response(
        self, h0: FactorValues, hv: FactorValues, **position: Unpack[Position]
    ) -> pd.DataFrame:
        """The response of the force to a changing amplitude, a row for each point.

        The columns are those of ``squeezefilm response --output``, among them ``static_gain``,
        ``corner_hz`` and ``settling_start_s``; ``status`` is ``ok``, or why there is none.
        Raises InputError as ``scene`` does.

        Example:
            >>> study.response(h0="5 um", hv="2.2 um")[["static_gain", "corner_hz"]]
        """
        from squeezefilm.dynamics.response import response_table

        points, solver = points_of_factors(h0=h0, hv=hv, **position), self.solver()
        how: dict[str, Any] = {"tolerance": solver.tolerance, "device": solver.device}
        return points.assign(**response_table(points, self.scenes(points), **how))

    def gains(
        self,
        h0: FactorValues,
        hv: FactorValues,
        *,
        frequencies: FactorValues,
        **position: Unpack[Position],
    ) -> pd.DataFrame:
        """Gain and phase of the force behind a modulated amplitude, a row for each frequency.

        Raises InputError as ``scene`` does.

        Example:
            >>> study.gains(h0="5 um", hv="2.2 um", frequencies="10, 100, 1000 Hz")["gain"]
        """
        from squeezefilm.api.points import Points
        from squeezefilm.dynamics.response import gain_table

        frequency_hz = parse_factor_values(frequencies, called="frequencies", unit="Hz")
        points = points_of_factors(h0=h0, hv=hv, **position)
        return Points(gain_table(points, self.scenes(points), np.array(frequency_hz)))

    def pressure(
        self,
        h0: str | float,
        hv: str | float,
        *,
        points_per_side: int = 41,
        time_points: int = 32,
        tolerance: float = PRESSURE_TOLERANCE,
        **position: Unpack[Position],
    ) -> xarray.Dataset:
        """Gauge pressure (Pa) and gap (m) under the pad over one period, with coordinates.

        ``phase`` and ``time`` of the vibration, ``y`` and ``x`` from the pad's centre along its
        own axes; NaN outside an elliptical pad.

        Args:
            points_per_side: number along x and along y, evenly spaced, film edge included.
            time_points: number per period; even.
            tolerance: largest change of a value under grid refinement, over the largest value.

        Raises InputError as ``scene`` does, for numbers out of range and without xarray, RunError
        where there is no state.

        Example:
            >>> field = study.pressure(h0="5 um", hv="2 um")
            >>> field.gauge_pressure.mean("phase").max()  # Pa
        """
        with imports_from_extra("fields", what="a pressure field"):
            import xarray
        for name, value, least, most in (
            ("points_per_side", points_per_side, *POINTS_PER_SIDE_RANGE),
            ("time_points", time_points, *TIME_POINTS_RANGE),
            ("tolerance", tolerance, 1e-8, 0.1),
        ):
            if not least <= value <= most:
                raise InputError(f"{name}: {value:g} must lie within {least:g} … {most:g}")
        if time_points % 2:
            raise InputError(f"time_points: {time_points} must be even")
        solver = self.solver(method="periodic")
        (scene,) = solver.with_auto_terms_decided([self.scene(h0, hv, **position)])
        across = np.linspace(0.0, 1.0, points_per_side)
        gauge_pressure_ratio, change = gauge_pressure_and_change(
            scene,
            x=across,
            y=across,
            time_points=time_points,
            tolerance=tolerance,
            device=self.device,
        )
        phase = 2 * np.pi * np.arange(time_points) / time_points
        gap_m = scene.h0_m * np.moveaxis(scene.gap(*np.meshgrid(across, across), phase), -1, 0)
        ambient, pad, axes = scene.gas.ambient_pressure_pa, scene.pad, ("phase", "y", "x")
        field = xarray.Dataset(
            {
                "gauge_pressure": (axes, ambient * gauge_pressure_ratio),
                "gap": (axes, np.where(np.isnan(gauge_pressure_ratio), np.nan, gap_m)),
            },
            coords={
                "phase": np.degrees(phase),
                "y": pad.length_y_m * (across - 0.5),
                "x": pad.length_x_m * (across - 0.5),
                "time": ("phase", phase / scene.actuator.angular_frequency_rad_per_s),
            },
            attrs={
                "title": "pressure of a squeeze film over one period",
                "h0_m": scene.h0_m,
                "hv_m": scene.hv_m,
                "pad_x_m": scene.x_m,
                "pad_y_m": scene.y_m,
                "frequency_hz": scene.actuator.frequency_hz,
                "ambient_pressure_pa": ambient,
                "inertia": scene.gas.inertia,
                "change_pa": ambient * change,
                "comment": "change_pa: most that a pressure changed by in the last refinement",
            },
        )
        for name, (unit, words) in UNIT_AND_LABEL_OF_VARIABLE.items():
            field[name].attrs |= {"units": unit, "long_name": words}
        return field

    def __repr__(self) -> str:
        actuator, pad = self.config.actuator, self.config.pad
        return (
            f"{type(self).__name__}: {actuator.profile.kind} at {actuator.frequency_hz / 1e3:g} "
            f"kHz under a pad of {1e3 * pad.length_x_m:g} mm × {1e3 * pad.length_y_m:g} mm "
            f"({pad.shape})"
        )

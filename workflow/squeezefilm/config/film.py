"""A study's configuration as models: every key with its unit, limits, default and meaning.

A key's meaning stands under ``Attributes`` in the docstring of its section, from which the table in
the documentation and an editor's schema are made (config/keys.py). Names in Python have their unit
(``frequency_hz``); keys in a file have none (``frequency: 43.27 kHz``), and there a number is in SI
units, or degrees, and a text has its unit.
"""

import re
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import pi, sqrt
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PrivateAttr,
    StrictBool,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from squeezefilm.units import in_unit

UNIT_OF_NAME = re.compile(r"_(m|hz|n|deg|k|pa|pa_s|kg_per_m3|m_per_s|per_m|rad_per_m)$")
LIKE_AIR = 0.05
"""By how much a written viscosity may differ, relative, from that of the gas that is named."""

Place = tuple[str | int, ...]
"""The keys, and numbers of a list's items, that lead to a value."""
Items = TypeVar("Items", bound=Iterable[Hashable])


def key_of(name: str) -> str:
    """The key in a file of what Python calls ``name``."""
    return UNIT_OF_NAME.sub("", name)


def mistake(
    text: str, *place: str, kind: Literal["relation", "missing"] = "relation"
) -> PydanticCustomError:
    """An error at a key further inside than where the validator is that raises it."""
    return PydanticCustomError(kind, "{text}", {"text": text, "place": place})


@dataclass(frozen=True)
class Number:
    """A number within limits, in SI units or as a text with its unit.

    Attributes:
        unit: SI, or degrees; ``1`` for none.
        open: whether the lower limit itself is not allowed.
    """

    unit: str
    low: float
    high: float
    open: bool = False

    def __get_pydantic_core_schema__(self, source: Any, _: GetCoreSchemaHandler) -> CoreSchema:
        low: dict[str, Any] = {"gt" if self.open else "ge": self.low}
        number = core_schema.float_schema(strict=True, allow_inf_nan=False, le=self.high, **low)
        return core_schema.no_info_before_validator_function(self._in_si, number)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        text = {"type": ["number", "string"], "unit": self.unit}  # limits are a number's alone
        return handler(schema) | (text if self.unit != "1" else {})

    def _in_si(self, value: Any) -> Any:
        """The value in SI units; as it is where it is no number with such a unit."""
        number = in_unit(value, self.unit) if isinstance(value, str) else None
        return value if number is None else number


def _different(values: Items) -> Items:
    if len(set(values)) < len(list(values)):
        raise mistake("a value stands twice")
    return values


Length = Annotated[float, Number("m", 1e-6, 10)]
Rise = Annotated[float, Number("m", -1e-3, 1e-3)]
Direction = Annotated[float, Number("°", -360, 360)]
Text = Annotated[str, Field(min_length=1, max_length=1000)]
Different = AfterValidator(_different)
DERIVED: Any = Field(default=None)
"""Of an optional key: ``default:`` in the docstring says what follows from others."""
Term = Literal["none", "included", "auto"]


def _described(schema: dict[str, Any]) -> None:
    """Put what a docstring says of keys to these, in a section's JSON schema."""
    about, _, attributes = schema.get("description", "").partition("\n\nAttributes:\n")
    schema["description"] = " ".join(about.partition("\n\n")[0].split())
    for name, meaning in re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", attributes, re.MULTILINE):
        key = schema["properties"][key_of(name)]
        key["description"], _, words = " ".join(meaning.split()).partition("; default: ")
        key |= {"derived": words} if words else {}


KEYS = ConfigDict(
    extra="forbid", alias_generator=key_of, defer_build=True, json_schema_extra=_described
)


class Section(BaseModel):
    model_config = KEYS


@dataclass(frozen=True)
class Gas:
    """The film's gas; air at 20 °C where nothing is written. Numbers that are not written are those
    of `name` at `ambient_temperature`; of another gas all are to be written. The paper states none.

    The film's own type: in Python its numbers may be any, in a study they are within limits. The
    density follows the pressure as ρ ~ p^(1/n), the mean free path goes like 1/ρ, as for molecules
    of a fixed size; ``auto`` is decided before a scene is solved, and the effects that the
    equation of a scene neglects enter its error budget alone (quantities/model_error.py).

    Attributes:
        viscosity_pa_s: dynamic viscosity μ; default: that of `name`, 1.81e-5 of air at 20 °C
        ambient_pressure_pa: pressure p0 around the pad
        density_kg_per_m3: density at ambient pressure, for the inertia of the gas; default: that
            of `name` under the pressure, 1.204 of air at 20 °C and 101325 Pa
        mean_free_path_m: mean free path at ambient density, for `rarefaction` and the budget; in
            the film it varies as 1/density; default: μ √(π/(2 p0 ρ)) of kinetic theory, 64.948 nm
            of air at 20 °C and 101325 Pa
        rarefaction: `none` (viscous flow), `slip` (first order, 6 Kn H²) or `fukui-kaneko` (flow
            factor of the linearised Boltzmann equation, at any Kn, for walls that reflect
            molecules diffusely)
        slip_coefficient: slip length over the mean free path with `rarefaction: slip`: 1 is
            Maxwell's, 6 Kn H² of flow; 1.147 that of kinetic theory, 6.88 Kn H²; more where walls
            reflect molecules like mirrors
        polytropic_exponent: n of ρ ~ p^(1/n): 1 for an isothermal film, 1.4 for adiabatic air
        inertia: whether the gas has inertia: `none`, as in the paper's equation;
            `included`; or `auto`, included in a scene whose force it changes by more than
            `solver.model_tolerance`
        thermal: whether compression and friction warm the gas, between walls that stay at ambient
            temperature: `none`, as in the paper's equation; `included`, with
            `polytropic_exponent` 1; or `auto`, included in a scene whose force it changes by more
            than `solver.model_tolerance`
        prandtl: Prandtl number, viscosity over conduction of heat; default: that of `name`, 0.71 of
            air
        heat_capacity_ratio: ratio γ of the specific heats; default: that of `name`, 1.4 of air
        viscosity_exponent: κ of the viscosity's growth with temperature, T^κ; default: that of
            `name`, 0.7 of air
        name: gas whose numbers are taken where none are written
        ambient_temperature_k: temperature of `name`, such as `20 °C`; a number is in kelvin
    """

    __pydantic_config__ = KEYS

    viscosity_pa_s: Annotated[float, Number("Pa s", 1e-7, 100)] = 1.81e-5
    ambient_pressure_pa: Annotated[float, Number("Pa", 1, 1e9)] = 101325.0
    density_kg_per_m3: Annotated[float, Number("kg/m³", 1e-6, 1e5)] = 1.204
    mean_free_path_m: Annotated[float, Number("m", 1e-12, 1)] = 64.948e-9
    rarefaction: Literal["none", "slip", "fukui-kaneko"] = "none"
    slip_coefficient: Annotated[float, Number("1", 0.1, 100)] = 1.0
    polytropic_exponent: Annotated[float, Number("1", 1, 1.67)] = 1.0
    inertia: Term = "auto"
    thermal: Term = "auto"
    prandtl: Annotated[float, Number("1", 1e-3, 1000)] = 0.71
    heat_capacity_ratio: Annotated[float, Number("1", 1, 1.68)] = 1.4
    viscosity_exponent: Annotated[float, Number("1", 0, 2)] = 0.7
    name: Literal["air", "nitrogen", "helium", "argon", "carbon dioxide", "hydrogen"] = "air"
    ambient_temperature_k: Annotated[float, Number("K", 223.15, 473.15)] = 293.15


GASES = Path(__file__).with_name("gases.csv")
"""Numbers of gases at some temperatures under the default pressure, with their sources."""


@cache
def _gases() -> np.ndarray:
    """Return the cells of GASES, its header first."""
    lines = GASES.read_text(encoding="utf-8").splitlines()
    return np.array([line.split(",") for line in lines if not line.startswith("#")])


def _numbers_of(gas: Gas) -> dict[str, float]:
    """Return the numbers of a gas by its name, temperature and pressure; powers of T between rows.

    Five digits, so that they are those of a row at its own temperature.
    """
    rows, own = _gases()[_gases()[:, 0] == gas.name, 1:].astype(float), {}
    kelvin, *columns = np.log(rows).T
    for name, values in zip(_gases()[0, 2:].tolist(), columns, strict=True):
        value = np.exp(np.interp(np.log(gas.ambient_temperature_k), kelvin, values))
        own[name] = float(f"{value:.5g}")
    pressure = gas.ambient_pressure_pa / Gas.ambient_pressure_pa
    own["density_kg_per_m3"] *= pressure
    return own


def _whole_gas(values: Any, validated: ValidatorFunctionWrapHandler) -> Gas:
    """A gas with what is not written of it: by its name, temperature and pressure."""
    gas = validated(values)
    own, written = _numbers_of(gas), values if isinstance(values, dict) else {}
    lacking = [each for each in own if key_of(each) not in written]
    viscosity = own["viscosity_pa_s"]
    if "viscosity" in written and abs(gas.viscosity_pa_s / viscosity - 1) > LIKE_AIR and lacking:
        raise mistake(
            f"{gas.viscosity_pa_s:g} is not that of {gas.name} at {gas.ambient_temperature_k:g} K, "
            f"{viscosity:.4g}; of another gas give {', '.join(map(key_of, lacking))} too, which "
            f"are {gas.name}'s where they are not written",
            "viscosity",
        )
    if gas.slip_coefficient != 1 and gas.rarefaction != "slip":
        raise mistake(
            f"{gas.slip_coefficient:g} is read with rarefaction: slip, and not with "
            f"{gas.rarefaction}",
            "slip_coefficient",
        )
    gas = replace(gas, **{each: own[each] for each in lacking})
    if key_of("mean_free_path_m") in written:
        return gas
    path_m = gas.viscosity_pa_s * sqrt(pi / 2 / gas.ambient_pressure_pa / gas.density_kg_per_m3)
    return replace(gas, mean_free_path_m=float(f"{path_m:.5g}"))


class Rectangle(Section):
    """A rectangular surface, instead of `surface_radius`; the pad must lie on it.

    Attributes:
        shape: its outline
        length_x_m: its side along x
        length_y_m: its side along y
    """

    shape: Literal["rectangle"]
    length_x_m: Length
    length_y_m: Length


class Sinc(Section):
    """A sinc.

    Attributes:
        wave_number_per_m: k, with r from the centre
    """

    kind: Literal["sinc"]
    wave_number_per_m: Annotated[float, Number("1/m", 0, 1e6, open=True)]


class Piston(Section):
    """A piston."""

    kind: Literal["piston"]


class StandingWave(Section):
    """A standing wave.

    Attributes:
        wavelength_m: λ
        direction_deg: direction of the wave, from the x axis
        crest_m: how far a crest lies from the centre; it may lie off the surface, the largest
            amplitude on which is 1
    """

    kind: Literal["standing-wave"]
    wavelength_m: Length
    direction_deg: Direction = 0.0
    crest_m: Annotated[float, Number("m", -10, 10)] = 0.0


class TravellingWave(Section):
    """A travelling wave.

    Attributes:
        wavelength_m: λ
        direction_deg: direction in which it travels, from the x axis
    """

    kind: Literal["travelling-wave"]
    wavelength_m: Length
    direction_deg: Direction = 0.0


class BesselMode(Section):
    """A bending mode of a disc.

    Attributes:
        nodal_diameters: n
        wave_number_rad_per_m: k
        edge_share: c, amplitude of the near field of the disc's edge; 0 for none
        direction_deg: φ0, direction of an antinode, from the x axis
    """

    kind: Literal["bessel"]
    nodal_diameters: Annotated[int, Field(strict=True, ge=0, le=20)]
    wave_number_rad_per_m: Annotated[float, Number("rad/m", 0, 1e6, open=True)]
    edge_share: Annotated[float, Number("1", -1e6, 1e6)] = 0.0
    direction_deg: Direction = 0.0


class Formula(Section):
    """A formula.

    Attributes:
        expression: arithmetic on `x`, `y`, `r` (m), `phi` (rad) and `pi`: + - * / **, sqrt, exp,
            log, sin, cos, tan, sinh, cosh, tanh, atan, abs, sinc. Divided by its largest magnitude
            on the surface
        quadrature: the same for what moves a quarter of a period ahead: the surface goes down by
            expression · sin ωt + quadrature · cos ωt, over the largest root of both squares on the
            surface; 0 where all moves in one phase
    """

    kind: Literal["formula"]
    expression: Text
    quadrature: Text = "0"


class Scan(Section):
    """A measured shape.

    Attributes:
        file: a vibrometer's table (see below), from the folder of this file
        axisymmetric: `true` if the shape depends on the distance from the centre alone; `false`
            leaves it free, and is what a rectangle needs
        sign: with `measured` a scan without phase and sign is invalid, for it is rectified at
            a node line; `unknown` takes it as it is, and every force says so
        rows: `COLUMN = VALUE`, the rows of one measurement where the table has several (a drive
            voltage); several conditions have semicolons between. Of a frequency column the rows at
            `actuator.frequency` are taken without
        scale: with `surface` an amplitude is that at the maximum of the surface; with `measured` at
            that of the measured points, beyond which it may be larger
    """

    kind: Literal["measured"]
    file: Text
    axisymmetric: StrictBool = False
    sign: Literal["measured", "unknown"] = "measured"
    rows: str = ""
    scale: Literal["surface", "measured"] = "surface"


Profile = Annotated[
    Sinc | Piston | StandingWave | TravellingWave | BesselMode | Formula | Scan,
    Field(discriminator="kind"),
]


class Actuator(Section):
    """The vibrating surface, a disc or a rectangle.

    Attributes:
        frequency_hz: frequency of the vibration
        surface_radius_m: of a disc: its radius; the pad must lie on it with all its corners
        profile: shape of the vibration, with maximum 1 on the surface. Its `kind` decides the other
            keys: `sinc`, sin(πkr)/(πkr) (paper eq. 2); `piston`, it moves as a whole;
            `standing-wave`, ~ cos(2πu/λ); `travelling-wave`, cos(ωt − 2πu/λ); `bessel`, a bending
            mode [J_n(kr) + c I_n(kr)] cos n(φ − φ0); `formula`; `measured`
    """

    frequency_hz: Annotated[float, Number("Hz", 1e-3, 1e9)]
    surface_radius_m: Length = DERIVED
    surface: Rectangle = DERIVED
    profile: Profile

    @model_validator(mode="after")
    def _one_surface(self) -> "Actuator":
        if (self.surface is None) == (self.surface_radius_m is None):
            raise mistake(
                "give surface_radius, of a disc, or surface, of a rectangle, and not both"
            )
        if self.surface and isinstance(self.profile, Scan) and self.profile.axisymmetric:
            raise mistake("a rectangle has no axis; it must be false", "profile", "axisymmetric")
        return self


class OutlineFile(Section):
    """File of a pad's outline.

    Attributes:
        file: a table of points around the rim (see below), from the folder of this file
        scatter_m: how far the points may lie off the smooth curve through them; 0 stands for 1e-4
            of the longer side
    """

    file: Text
    scatter_m: Annotated[float, Number("m", 0, 1)] = 0.0


@dataclass(frozen=True)
class GapShape:
    """Deviation of the gap at rest from h0, the gap at the pad's centre; all zero if pad and
    surface are parallel.

    Attributes:
        tilt_x_m: gap at the middle of the side at +x less that at −x
        tilt_y_m: gap at the middle of the side at +y less that at −y
        crown_m: gap at the middle of every side less that at the centre; elsewhere the gap grows by
            crown ((2x/length_x)² + (2y/length_y)²); positive for a pad whose crown is towards the
            surface
    """

    __pydantic_config__ = KEYS

    tilt_x_m: Rise = 0.0
    tilt_y_m: Rise = 0.0
    crown_m: Rise = 0.0

    @property
    def flat(self) -> bool:
        return not (self.tilt_x_m or self.tilt_y_m or self.crown_m)

    def rise_m(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Gap at rest less h0 at positions in [0, 1] across the pad."""
        x, y = x - 0.5, y - 0.5
        tilt: np.ndarray = self.tilt_x_m * x + self.tilt_y_m * y
        return tilt + 4 * self.crown_m * (x**2 + y**2)


SIDES = ("length_x_m", "length_y_m")


def _described_with_circle(schema: dict[str, Any]) -> None:
    circle = {"properties": {"shape": {"const": "circle"}}, "required": ["shape"]}
    sides = {"required": list(map(key_of, SIDES))}
    schema |= {"if": circle, "then": {"required": ["diameter"]}, "else": sides}
    _described(schema)


class Pad(Section):
    """The pad.

    Attributes:
        shape: its outline
        length_x_m: the rectangle's side, the ellipse's axis or the curve's extent, along x;
            default: of a circle the diameter; else it must be written
        length_y_m: the same along y; default: the same along y
        diameter_m: of a circle, instead of its lengths
        rotation_deg: by how much its x axis is turned from the actuator's, against the clock
        speed_x_m_per_s: speed at which the surface passes it, along the pad's +x axis; 0 at rest
    """

    model_config = ConfigDict(json_schema_extra=_described_with_circle)

    shape: Literal["rectangle", "ellipse", "circle", "curve"] = "rectangle"
    diameter_m: Length = DERIVED
    outline: OutlineFile = DERIVED
    length_x_m: Length = DERIVED
    length_y_m: Length = DERIVED
    rotation_deg: Direction = 0.0
    speed_x_m_per_s: Annotated[float, Number("m/s", -10000, 10000)] = 0.0
    gap: GapShape = Field(default_factory=GapShape)

    @model_validator(mode="after")
    def _outlined(self) -> "Pad":
        """Return the pad with the keys of its shape alone; a circle is an ellipse of equal axes."""
        own = {"circle": ("diameter_m",), "curve": (*SIDES, "outline")}.get(self.shape, SIDES)
        for name in (*SIDES, "diameter_m", "outline"):
            if (getattr(self, name) is None) == (name in own):
                key, keys = key_of(name), ", ".join(map(key_of, own))
                text = f"with shape: {self.shape} give {keys}, not {key}"
                raise mistake(text, key, kind="missing" if name in own else "relation")
        if self.shape != "circle":
            return self
        sides = dict.fromkeys(SIDES, self.diameter_m)
        return self.model_copy(update={"shape": "ellipse", "diameter_m": None} | sides)


class Solver(Section):
    """Settings of the solver.

    Attributes:
        method: `auto` takes, for each scene, the composite expansion where the squeeze number is
            large and it meets the tolerance, else the periodic state; or one by name
        tolerance: required relative error of each force
        model_tolerance: relative change of a force from which on `auto` includes a term of the
            equation
        device: OpenCL device: a part of its platform's or its own name, or `auto`. The environment
            variable `SQUEEZEFILM_DEVICE` overrides it, and the option `--device` of a command
            overrides both
    """

    method: Literal["auto", "composite", "periodic"] = "auto"
    tolerance: Annotated[float, Number("1", 1e-10, 0.1)] = 1e-4
    model_tolerance: Annotated[float, Number("1", 1e-6, 0.5)] = 1e-3
    device: Annotated[str, Field(min_length=1)] = "auto"


Output = Literal[
    "harmonics", "power", "centre", "moments", "thrust", "extremes", "static_stiffness"
]


class FilmSections(Section):
    """A film and how it is solved: what a command needs that simulates single scenes."""

    _path: Path = PrivateAttr(default=Path("study"))
    _written: Mapping[Place, Any] = PrivateAttr(default_factory=dict)

    gas: Annotated[Gas, WrapValidator(_whole_gas)] = Field(default={}, validate_default=True)
    actuator: Actuator
    pad: Pad
    solver: Solver = Field(default_factory=Solver)
    outputs: Annotated[list[Output], Different] = Field(
        default=[],
        description="quantities beside the mean force in every `forces.csv`, each with its error "
        "(docs/outputs.md)",
    )

    @property
    def path(self) -> Path:
        """The file of the study, from whose folder those that it names count."""
        return self._path

    @property
    def written(self) -> Mapping[Place, Any]:
        """Values that were written, by their places; all others follow or are defaults."""
        return self._written

    def read_from(self, path: Path, values: Mapping[str, Any]) -> Self:
        """The study, which was read from these values of a file."""
        self._path, self._written = path, dict(_written(values))
        return self

    def sections(self, *names: str) -> dict[str, Any]:
        """Plain values, ready for JSON, by the names that Python has for keys (``frequency_hz``).

        Args:
            names: of sections; all without.
        """
        return self.model_dump(include=set(names) or None, exclude_none=True)


def _written(values: Any, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    if isinstance(values, Mapping):
        for name, value in values.items():
            yield (*place, name), value
            yield from _written(value, (*place, name))

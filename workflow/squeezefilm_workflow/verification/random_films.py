"""Random films by their dimensionless numbers: rows of a table, and scenes for the solver.

Numbers that a row does not draw are those of a plain film. A film is of one of GROUP_PERCENTAGES:

- excursion ratio ε uniform in 0.01 to 0.98, squeeze number σ log-uniform in 0.1 to 1e6;
- *sliding*: bearing number log-uniform in 0.1 to 300;
- *shaped gap*: tilted or crowned, ε at most 0.9 of the least gap at rest; or two quadrature
  components; or both; σ at most 1e5;
- *ellipse*: axes 1 : 0.5 to 1 : 1; ε at most 0.9, σ at most 1e4;
- *slip*: Knudsen number log-uniform in 1e-3 to 0.1;
- *inertia* and *thermal*: modified Reynolds number log-uniform in 0.05 to 5, ε Re at most 2, ε at
  most 0.8, σ in 1 to 1e5; tolerances of 1e-4 and looser, for direct solutions take minutes.

A quarter of the pads is centred, the others lie up to 0.3 sides off along x and y. Profiles are
pistons, smooth ones, measured ones (Zernike modes), ridges, kinks and narrow spots, as of
PROFILE_PERCENTAGES. Ten films with successive numbers share profile and position, since sampling a
profile takes longer than solving a film.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import cos, exp, log, pi, sin
from typing import Any

import numpy as np

from squeezefilm.film.profiles import Formula, ModeSum, Profile, largest_magnitude
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm_workflow.verification.films import (
    MAX_EPSILON_TIMES_REYNOLDS,
    PAD_LENGTH_M,
    film_scene,
    gap_shape,
)

SURFACE_DISC = Disc(0.012)
# Probabilities in per cent.
GROUP_PERCENTAGES = {
    "even gap": 36,
    "sliding": 18,
    "shaped gap": 18,
    "slip": 6,
    "ellipse": 6,
    "inertia": 10,
    "thermal": 6,
}
PROFILE_PERCENTAGES = {
    "piston": 8,
    "smooth": 34,
    "measured": 14,
    "ridge": 18,
    "kink": 6,
    "narrow": 20,
}
EPSILON_RANGE, SIGMA_RANGE, BEARING_RANGE = (0.01, 0.98), (0.1, 1e6), (0.1, 300.0)
REYNOLDS_RANGE = (0.05, 5.0)
KNUDSEN_RANGE, ASPECT_RANGE = (1e-3, 0.1), (0.5, 1.0)
CENTRED_PROBABILITY, MAX_OFF_CENTRE_FRACTION = 0.25, 0.3
RANGES_OF_GROUP = {
    "shaped gap": {"epsilon": (0.01, 0.9), "sigma": (1.0, 1e5)},
    "ellipse": {"epsilon": (0.01, 0.9), "sigma": (1.0, 1e4)},
    "inertia": {"epsilon": (0.01, 0.8), "sigma": (1.0, 1e5)},
    "thermal": {"epsilon": (0.01, 0.8), "sigma": (1.0, 1e5)},
}
MAX_ZERNIKE_DEGREE = 8
FILMS_PER_PROFILE = 10
# An excursion ratio at which no gap is closed.
SMALL_EPSILON = 1e-3
# Loose tolerances are drawn more often: there two grids agree by chance, and films are cheap.
TOLERANCE_PERCENTAGES = {1e-2: 40, 1e-3: 30, 1e-4: 20, 1e-5: 6, 1e-6: 4}
MIN_TOLERANCE_WITH_INERTIA = 1e-4


@dataclass(frozen=True)
class RandomFilm:
    """A film as a row of a table.

    Attributes:
        epsilon: excursion ratio; of a shaped gap over its least gap at rest.
        x, y: the pad's centre, in units of its side along x, as all lengths are.
        tilt_x, tilt_y, crown: of the gap at rest, over h0.
        profile: a formula of x and y in metres, or ``zernike`` and coefficients to degree 8.
        quadrature: formula of the second component, ``0`` for none.
        tolerance: at which the film is solved.
    """

    group: str
    epsilon: float
    sigma: float
    profile: str
    tolerance: float
    bearing: float = 0.0
    x: float = 0.0
    y: float = 0.0
    aspect: float = 1.0
    knudsen: float = 0.0
    reynolds: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    crown: float = 0.0
    quadrature: str = "0"

    @property
    def scene(self) -> Scene:
        scene = film_scene(
            self.group,
            self.epsilon,
            self.sigma,
            self.bearing,
            profile=self._vibration_profile(),
            x=self.x,
            y=self.y,
            aspect=self.aspect,
            knudsen=self.knudsen,
            reynolds=self.reynolds,
            gap=gap_shape(self.tilt_x, self.tilt_y, self.crown),
            shape="ellipse" if self.group == "ellipse" else "rectangle",
        )
        return scene.with_gas(thermal="included") if self.group == "thermal" else scene

    def _vibration_profile(self) -> Profile:
        kind, *coefficients = self.profile.split(" ")
        if kind == "zernike":
            orders = SURFACE_DISC.orders_up_to(MAX_ZERNIKE_DEGREE)
            return ModeSum(orders, tuple(map(float, coefficients)), SURFACE_DISC)
        return Formula(self.profile, SURFACE_DISC, self.quadrature)


def random_film(
    number: int,
    *,
    seed: int,
    groups: Mapping[str, int] = GROUP_PERCENTAGES,
    profiles: Mapping[str, int] = PROFILE_PERCENTAGES,
    **limits: tuple[float, float],
) -> RandomFilm:
    """The film of a number, whatever others are drawn.

    Args:
        groups, profiles: probabilities in per cent.
        limits: of ``epsilon``, ``sigma``, ``bearing`` or ``reynolds`` other than the docstring's.
    """
    random = np.random.default_rng((seed, number))
    group = _draw_by_percentages(random, groups)
    limits = (
        {"epsilon": EPSILON_RANGE, "sigma": SIGMA_RANGE} | RANGES_OF_GROUP.get(group, {}) | limits
    )
    shared = np.random.default_rng((seed, number // FILMS_PER_PROFILE, FILMS_PER_PROFILE))
    x, y = shared.uniform(-MAX_OFF_CENTRE_FRACTION, MAX_OFF_CENTRE_FRACTION, 2) * (
        shared.uniform() > CENTRED_PROBABILITY
    )
    drawn = RandomFilm(
        group=group,
        epsilon=float(random.uniform(*limits["epsilon"])),
        sigma=log_uniform(random, limits["sigma"]),
        profile=_random_profile_formula(shared, x * PAD_LENGTH_M, y * PAD_LENGTH_M, profiles),
        tolerance=float(_draw_by_percentages(random, TOLERANCE_PERCENTAGES)),
        x=float(x),
        y=float(y),
    )
    match group:
        case "sliding":
            return replace(drawn, bearing=log_uniform(random, limits.get("bearing", BEARING_RANGE)))
        case "slip":
            return replace(drawn, knudsen=log_uniform(random, KNUDSEN_RANGE))
        case "ellipse":
            return replace(drawn, aspect=log_uniform(random, ASPECT_RANGE))
        case "inertia" | "thermal":
            reynolds = log_uniform(random, limits.get("reynolds", REYNOLDS_RANGE))
            reynolds = min(reynolds, MAX_EPSILON_TIMES_REYNOLDS / drawn.epsilon)
            tolerance = max(drawn.tolerance, MIN_TOLERANCE_WITH_INERTIA)
            return replace(drawn, reynolds=reynolds, tolerance=tolerance)
        case "shaped gap":
            return _film_with_nonuniform_gap(random, drawn)
    return drawn


def log_uniform(random: np.random.Generator, limits: tuple[float, float]) -> float:
    """A number that is uniform in its logarithm."""
    low, high = limits
    return exp(random.uniform(log(low), log(high)))


def _draw_by_percentages(random: np.random.Generator, frequencies: Mapping[Any, int]) -> str:
    weights = np.array(list(frequencies.values())) / sum(frequencies.values())
    return str(random.choice(list(frequencies), p=weights))


def _film_with_nonuniform_gap(random: np.random.Generator, drawn: RandomFilm) -> RandomFilm:
    """A film whose gap is shaped at rest, has two components, or both."""
    shaped = random.uniform() < 0.7
    if not shaped or random.uniform() < 0.3:
        profile = _smooth_profile_formula(random)
        while drawn.profile.startswith("zernike"):
            drawn = replace(drawn, profile=_random_profile_formula(random, 0.0, 0.0))
        drawn = replace(drawn, quadrature=profile)
    if not shaped:
        return drawn
    tilt, angle = random.uniform(0.1, 0.8), random.choice([0.0, random.uniform(0, pi / 2)])
    drawn = replace(
        drawn,
        tilt_x=float(tilt * cos(angle)),
        tilt_y=float(tilt * sin(angle)),
        crown=float(random.choice([0.0, random.uniform(-0.1, 1.0)])),
    )
    # The excursion is a share of the gap where the pad is nearest to the surface.
    closure = replace(drawn, epsilon=SMALL_EPSILON).scene.closure() / SMALL_EPSILON
    return replace(drawn, epsilon=drawn.epsilon / closure)


def _random_profile_formula(
    random: np.random.Generator,
    x_m: float,
    y_m: float,
    frequencies: Mapping[str, int] = PROFILE_PERCENTAGES,
) -> str:
    """A profile whose features lie under or near a pad at x, y."""
    kind = _draw_by_percentages(random, frequencies)
    if kind == "piston":
        return "1"
    if kind == "smooth":
        return _smooth_profile_formula(random)
    if kind == "measured":
        return _random_zernike_text(random)
    at_x, at_y = np.array([x_m, y_m]) + random.uniform(-0.4, 0.4, 2) * PAD_LENGTH_M
    angle, height = random.uniform(0, pi), random.uniform(0.1, 0.9)
    along = f"({cos(angle):.6f}*(x-({at_x:.6g}))+{sin(angle):.6f}*(y-({at_y:.6g})))"
    if kind == "kink":
        return f"1-{height:.4f}*abs({along})/{1.5 * SURFACE_DISC.radius_m:.6g}"
    if kind == "ridge":
        width_m = log_uniform(random, (PAD_LENGTH_M / 15, PAD_LENGTH_M / 3))
        return f"1-{height:.4f}*exp(-({along}/{width_m:.6g})**2)"
    width_m = log_uniform(random, (PAD_LENGTH_M / 25, PAD_LENGTH_M / 5))
    sign = random.choice(["-", "+"])
    spot = f"exp(-((x-({at_x:.6g}))**2+(y-({at_y:.6g}))**2)/{width_m:.6g}**2)"
    return f"1{sign}{height:.4f}*{spot}"


def _smooth_profile_formula(random: np.random.Generator) -> str:
    """The paper's profile with other wave numbers, or a standing wave."""
    if random.uniform() < 0.5:
        return f"sinc({random.uniform(30, 300):.6g}*r)"
    rate = 2 * pi / log_uniform(random, (0.5 * PAD_LENGTH_M, 3 * PAD_LENGTH_M))
    angle, phase = random.uniform(0, pi), random.uniform(0, 2 * pi)
    return f"cos({rate * cos(angle):.6g}*x+{rate * sin(angle):.6g}*y+{phase:.6g})"


def _random_zernike_text(random: np.random.Generator) -> str:
    """Zernike modes as the smoothing of a scan has them: the finer the smaller."""
    orders = SURFACE_DISC.orders_up_to(MAX_ZERNIKE_DEGREE)
    sizes = random.standard_normal(len(orders)) * [0.5 ** order[0] for order in orders]
    modes = ModeSum(orders, tuple(sizes), SURFACE_DISC)
    largest = largest_magnitude(
        lambda x_m, y_m: modes.amplitude(x_m=x_m, y_m=y_m), surface=SURFACE_DISC
    )
    return " ".join(["zernike", *(f"{size:.9g}" for size in sizes / largest)])

"""Random films without inertia: any numbers, place and kind of profile."""

from __future__ import annotations

import math

import numpy as np

from numerics.films import LENGTH_M, PISTON, Film
from squeezefilm.film.vibration.shapes import (
    Formula,
    Modes,
    Profile,
    Sinc,
    StandingWave,
    largest_magnitude,
)
from squeezefilm.film.vibration.surfaces import Disc
from squeezefilm.film.vibration.zernike import orders_up_to

EPSILON = (0.01, 0.98)
SIGMA = (0.1, 1e6)
BEARING = (0.1, 300.0)
SLIDING = 0.5
# Share of films whose finger is at the centre, where the film may be folded.
CENTRED = 0.25
FARTHEST = 0.3
DISC_M = 0.012
DISC = Disc(DISC_M)
# Kinds of profiles, and how many of a hundred have them.
KINDS = {
    "piston": 8,
    "smooth": 34,
    "measured": 14,
    "ridge": 18,
    "kink": 6,
    "narrow": 20,
}


def random_film(index: int, *, seed: int) -> Film:
    """The film of a number, whatever others are drawn; its name is its profile's kind."""
    random = np.random.default_rng((seed, index))
    shares = np.array(list(KINDS.values())) / sum(KINDS.values())
    kind = str(random.choice(list(KINDS), p=shares))
    x, y = random.uniform(-FARTHEST, FARTHEST, 2) * (random.uniform() > CENTRED)
    sliding = random.uniform() < SLIDING
    return Film(
        name=kind,
        epsilon=random.uniform(*EPSILON),
        sigma=between(random, SIGMA),
        bearing=between(random, BEARING) if sliding else 0.0,
        profile=random_profile(kind, random, x=x * LENGTH_M, y=y * LENGTH_M),
        x=float(x),
        y=float(y),
    )


def between(random: np.random.Generator, bounds: tuple[float, float]) -> float:
    """Uniform in its logarithm."""
    return math.exp(random.uniform(*np.log(bounds)))


def random_profile(kind: str, random: np.random.Generator, *, x: float, y: float) -> Profile:
    """A profile of a kind whose features lie under a finger at x, y (metres)."""
    if kind == "piston":
        return PISTON
    if kind == "smooth":
        if random.uniform() < 0.5:
            return Sinc(wave_number_per_m=random.uniform(30.0, 300.0))
        return StandingWave(
            wavelength_m=between(random, (0.5 * LENGTH_M, 3 * LENGTH_M)),
            direction_deg=random.uniform(0, 180),
            crest_m=random.uniform(-0.5, 0.5) * LENGTH_M,
            surface=DISC,
        )
    if kind == "measured":
        return _measured(random)
    at_x, at_y = np.array([x, y]) + random.uniform(-0.4, 0.4, 2) * LENGTH_M
    angle = random.uniform(0, math.pi)
    along = f"({math.cos(angle):.6f}*(x-({at_x:.6g}))+{math.sin(angle):.6f}*(y-({at_y:.6g})))"
    height = random.uniform(0.1, 0.9)
    if kind == "ridge":
        width_m = between(random, (LENGTH_M / 15, LENGTH_M / 3))
        return _formula(f"1-{height:.4f}*exp(-({along}/{width_m:.6g})**2)")
    if kind == "kink":
        return _formula(f"1-{height:.4f}*abs({along})/{1.5 * DISC_M:.6g}")
    width_m = between(random, (LENGTH_M / 25, LENGTH_M / 5))
    spot = f"exp(-((x-({at_x:.6g}))**2+(y-({at_y:.6g}))**2)/{width_m:.6g}**2)"
    sign = "-" if random.uniform() < 0.5 else "+"
    return _formula(f"1{sign}{height:.4f}*{spot}")


def _formula(expression: str) -> Formula:
    return Formula(expression, surface=DISC)


def _measured(random: np.random.Generator) -> Modes:
    """Zernike modes as a scan's fit has them: the finer the smaller."""
    orders = orders_up_to(8, axisymmetric=False)
    sizes = random.standard_normal(len(orders)) * [0.5**n for n, _ in orders]
    profile = Modes(orders, tuple(sizes), DISC)
    largest = largest_magnitude(lambda x_m, y_m: profile.amplitude(x_m=x_m, y_m=y_m), surface=DISC)
    return Modes(orders, tuple(sizes / largest), DISC)

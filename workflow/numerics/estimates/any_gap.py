"""Random films with any gap: tilted or bulging rectangles, surfaces that move in two phases."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from numerics.estimates.films import (
    CENTRED,
    DISC,
    FARTHEST,
    KINDS,
    between,
    random_profile,
)
from numerics.films import H0_M, LENGTH_M, Film
from squeezefilm.film.finger import GapShape
from squeezefilm.film.vibration.shapes import StandingWave, TwoPhases, Vibration, largest_magnitude

# Largest excursion over the gap at rest, where the two are nearest to each other.
CLOSURE = (0.01, 0.9)
SIGMA = (1.0, 1e5)
SLIDING, BEARING = 0.2, (0.1, 30.0)
# Narrowest gap at rest over h0, and the most by which it rises elsewhere.
NARROWEST, MOST_RISE = (0.2, 0.95), 2.0
GAPS = {"tilted": 25, "bulging": 20, "tilted, bulging": 20, "flat": 35}
# Share of films in two phases; of flat ones all.
TWO_PHASES = 0.3
PROFILES = ("piston", "smooth", "measured", "ridge", "narrow")


def random_gap_film(index: int, *, seed: int) -> Film:
    """The film of a number, whatever others are drawn; its name says what is not plain in it."""
    random = np.random.default_rng((seed, index))
    kind = _drawn(random, GAPS)
    x, y = random.uniform(-FARTHEST, FARTHEST, 2) * (random.uniform() > CENTRED)
    moves = "one phase"
    if kind == "flat" or random.uniform() < TWO_PHASES:
        moves = "travelling" if random.uniform() < 0.4 else "two modes"
    if moves == "travelling":
        profile = _travelling(random)
    elif moves == "two modes":
        profile = _two_modes(random, x=x * LENGTH_M, y=y * LENGTH_M)
    else:
        moves = _drawn(random, {name: KINDS[name] for name in PROFILES})
        profile = random_profile(moves, random, x=x * LENGTH_M, y=y * LENGTH_M)
    film = Film(
        name=f"{kind}, {moves}",
        epsilon=1.0,
        sigma=between(random, SIGMA),
        bearing=between(random, BEARING) if random.uniform() < SLIDING else 0.0,
        profile=profile,
        x=float(x),
        y=float(y),
        gap=_gap(kind, random),
    )
    scene, closure = film.scene, random.uniform(*CLOSURE)
    places = scene.inside()
    excursion = float(np.max(scene.magnitude(*places) / scene.rest_gap(*places)))
    # A finger over next to a node of its profile could close its gap by more than h0 elsewhere.
    return replace(film, epsilon=min(closure / excursion, CLOSURE[1]))


def _drawn(random: np.random.Generator, shares: dict[str, int]) -> str:
    weights = np.array(list(shares.values()), dtype=float)
    return str(random.choice(list(shares), p=weights / weights.sum()))


def _gap(kind: str, random: np.random.Generator) -> GapShape:
    """A shape that leaves a share of h0 where it is narrowest."""
    angle, steep = random.uniform(0, 2 * math.pi), random.uniform(0.2, 1)
    hollow = random.choice([-1.0, 1.0]) * random.uniform(0.2, 1)
    narrowest = random.uniform(*NARROWEST)
    if kind == "flat":
        return GapShape()
    # Along one side, where a half of the finger may be left out, or across.
    along = random.uniform() < 0.4
    tilt_x, tilt_y = (1.0, 0.0) if along else (math.cos(angle), math.sin(angle))
    shape = GapShape(
        tilt_x_m=H0_M * steep * tilt_x * (kind != "bulging"),
        tilt_y_m=H0_M * steep * tilt_y * (kind != "bulging"),
        bulge_m=H0_M * hollow * (kind != "tilted"),
    )
    net = np.meshgrid(np.linspace(0, 1, 25), np.linspace(0, 1, 25))
    rise = shape.rise_m(*net) / H0_M
    size = MOST_RISE / max(float(np.abs(rise).max()), 1e-9)
    if rise.min() < 0:
        size = min(size, (1 - narrowest) / -float(rise.min()))
    return GapShape(size * shape.tilt_x_m, size * shape.tilt_y_m, size * shape.bulge_m)


def _travelling(random: np.random.Generator) -> Vibration:
    wave = StandingWave(
        wavelength_m=between(random, (0.5 * LENGTH_M, 3 * LENGTH_M)),
        direction_deg=random.choice([0.0, 90.0, random.uniform(0, 180)]),
        crest_m=0.0,
    )
    return TwoPhases(wave, replace(wave, crest_m=-wave.wavelength_m / 4))


def _two_modes(random: np.random.Generator, *, x: float, y: float) -> Vibration:
    """Two of the profiles in one phase with any lag, over the largest of their root of squares."""
    kinds = [_drawn(random, {name: KINDS[name] for name in PROFILES}) for _ in range(2)]
    first, second = (random_profile(kind, random, x=x, y=y) for kind in kinds)
    share = random.uniform(0.15, 1.4)
    shares = math.cos(share), math.sin(share)
    both = TwoPhases(first, second, shares=shares)
    largest = largest_magnitude(
        lambda x_m, y_m: np.hypot(*both.parts(x_m=x_m, y_m=y_m)), surface=DISC
    )
    return replace(both, shares=(shares[0] / largest, shares[1] / largest))

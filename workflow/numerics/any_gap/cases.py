"""Stiff and extreme films whose gap is shaped at rest or moves in two phases, or that are round."""

from __future__ import annotations

from dataclasses import replace

from numerics.films import H0_M, LENGTH_M, PISTON, SINC, Film
from squeezefilm.film.finger import GapShape
from squeezefilm.film.vibration.shapes import StandingWave, TwoPhases, Vibration

GROUP = "any gap, ellipse"


def travelling(wavelength: float = 2.0, direction_deg: float = 0.0) -> Vibration:
    """A wave of a length in units of the finger's side."""
    wave = StandingWave(wavelength * LENGTH_M, direction_deg, crest_m=0.0)
    return TwoPhases(wave, replace(wave, crest_m=-wave.wavelength_m / 4))


def shape(tilt_x: float = 0.0, tilt_y: float = 0.0, bulge: float = 0.0) -> GapShape:
    """A gap at rest in units of h0."""
    return GapShape(tilt_x * H0_M, tilt_y * H0_M, bulge * H0_M)


TILTED, BULGING, HOLLOW = shape(tilt_x=0.4), shape(bulge=0.3), shape(bulge=-0.25)


def films() -> list[tuple[Film, bool]]:
    """From a thick layer to a thin one; with each, whether a sample has it."""
    kinds = {
        "travelling wave": Film("", 0.5, 583.0, profile=travelling()),
        "short wave travelling across": Film("", 0.5, 583.0, profile=travelling(0.7, 30.0)),
        "tilted": Film("", 0.5, 583.0, gap=TILTED),
        "bulging": Film("", 0.5, 583.0, gap=BULGING),
        "hollow, tilted both ways": Film("", 0.3, 583.0, gap=shape(0.3, 0.2, -0.1)),
        "ellipse": Film("", 0.5, 583.0, shape="ellipse", aspect=0.7),
    }
    sampled = {("travelling wave", 1e5), ("tilted", 20.0), ("bulging", 2331.0), ("ellipse", 20.0)}
    found = [
        (replace(film, name=f"{kind}, σ = {sigma:g}", sigma=sigma), (kind, sigma) in sampled)
        for kind, film in kinds.items()
        for sigma in (1.0, 20.0, 2331.0, 1e5)
        if film.shape == "rectangle" or sigma < 1e5
    ]
    wave = travelling()
    single = {
        "travelling wave, ε = 0.95": Film("", 0.95, 583.0, profile=wave),
        "travelling wave, ε = 0.001": Film("", 1e-3, 583.0, profile=wave),
        "travelling wave, σ = 1e7": Film("", 0.5, 1e7, profile=wave),
        "tilted, a fifth of the gap left": Film("", 0.15, 583.0, gap=shape(1.6)),
        "tilted, 90 % of the gap closed": Film("", 0.9 * 0.8, 583.0, profile=PISTON, gap=TILTED),
        "tilted at the rim of the disc": Film("", 0.4, 2331.0, x=0.2051, y=0.2051, gap=TILTED),
        "tilted under a travelling wave": Film("", 0.4, 2331.0, profile=wave, gap=shape(0.3, 0.3)),
        "tilted, sliding, Λ = 30": Film("", 0.4, 583.0, 30.0, gap=TILTED),
        "bulging, rarefied gas, Kn = 0.05": Film("", 0.4, 583.0, knudsen=0.05, gap=BULGING),
        "thin finger 1 : 20, tilted along": Film(
            "", 0.01, 20.0, profile=PISTON, aspect=20.0, gap=shape(tilt_y=0.4)
        ),
        "travelling wave, inertia, Re = 0.5": Film("", 0.5, 583.0, profile=wave, reynolds=0.5),
        "tilted, inertia, Re = 0.5": Film("", 0.4, 583.0, reynolds=0.5, gap=TILTED),
        "ellipse, tilted": Film("", 0.3, 200.0, profile=SINC, shape="ellipse", gap=TILTED),
        "tilted until it touches": Film("", 0.5, 583.0, gap=shape(1.7)),
    }
    in_sample = {"tilted under a travelling wave", "tilted until it touches"}
    return found + [(replace(film, name=name), name in in_sample) for name, film in single.items()]

"""How much the mean force falls as the mean gap grows, the amplitude kept: −∂F/∂h0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Outputs, Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.derivatives import with_derivatives
from squeezefilm.reynolds.solver import solve

NAME = "static_stiffness"
# Half the distance of gaps in a difference quotient, relative; taken once more twice as wide, whose
# difference bounds what the quotient misses.
STEP = 0.01
AROUND = (-2, -1, 1, 2)


def quotient(forces: Sequence[float], errors: Sequence[float], h0_m: float) -> tuple[float, float]:
    """Stiffness and its error from forces at the gaps h0 (1 + k STEP), k of AROUND."""
    a, b, c, d = forces
    narrow, wide = (b - c) / (2 * STEP * h0_m), (a - d) / (4 * STEP * h0_m)
    # The wide quotient misses four times what the narrow one does.
    noise = (errors[1] + errors[2]) / (2 * STEP * h0_m)
    return narrow + (narrow - wide) / 3, abs(narrow - wide) / 3 + 4 / 3 * noise


def static_stiffness(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    tolerance: float,
    device: Device,
) -> list[Outputs]:
    """By the force's derivative, or where that is not known by a quotient of four more forces.

    The scenes' terms must be decided (effects/automatic.py).
    """
    found = with_derivatives(scenes, solutions, tolerance=tolerance, device=device)
    each = [one.derivatives for one in found]
    known = [
        Outputs(value={NAME: -it.value["h0_m"]}, error={NAME: it.error["h0_m"]})
        if it and it.status == "ok"
        else None
        for it in each
    ]
    rest = [k for k, output in enumerate(known) if output is None]
    moved = [replace(scenes[k], h0_m=scenes[k].h0_m * (1 + n * STEP)) for k in rest for n in AROUND]
    forces = solve(moved, tolerance=tolerance, device=device)
    for place, k in enumerate(rest):
        some = forces[len(AROUND) * place : len(AROUND) * (place + 1)]
        known[k] = _by_quotient(some, scenes[k].h0_m)
    return [output for output in known if output]


def _by_quotient(forces: Sequence[Solution], h0_m: float) -> Outputs:
    if bad := next((each.status for each in forces if each.status != "ok"), ""):
        return Outputs(refused={NAME: f"no force at a gap within {2 * STEP:.0%}: {bad}"})
    value, error = quotient(
        [each.force_n for each in forces], [each.force_error_n for each in forces], h0_m
    )
    return Outputs(value={NAME: value}, error={NAME: error})

"""From a film by two resolutions to its answers, each with an error."""

from __future__ import annotations

from dataclasses import dataclass

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import OUTPUTS, Outputs
from squeezefilm.reynolds.answers.refused import formula_refusals
from squeezefilm.reynolds.answers.samples import Sample
from squeezefilm.reynolds.answers.weights import FORCE, GUARD, varies, weights_of
from squeezefilm.reynolds.error_estimate import ROUND_OFF, ROUNDED
from squeezefilm.reynolds.terms.heat import Heat

# No answer changes less than this share of the largest change among those alike, each over its
# size: it may agree by chance, or be small because its parts cancel.
SHARE_OF_OTHERS = 0.3
# An extreme is one value of a polynomial, which nothing averages: the worst of 600 random films at
# 1e-2 needed 2.8 times what its change and the iteration left.
EXTREMES = 4.0


@dataclass(frozen=True)
class Answered:
    """Answers of one film, and whether those alike hold the tolerance together."""

    outputs: Outputs
    holds: bool


def answered(
    before: Sample, film: Sample, *, factor: float, left: float, tolerance: float
) -> Answered:
    """All answers that follow from a state.

    Args:
        before: the same film by a coarser resolution.
        factor: what is left after a change, in units of it.
        left: what else the pressure may be off by, in units of the ambient one.
    """
    left += ROUND_OFF * max(film.largest, -film.least)
    value, error, holds, least = _means(before, film, factor=factor, left=left, tolerance=tolerance)
    refused = formula_refusals(film.scene)
    _add_extremes(before, film, value, error, factor=factor, left=left, least=least)
    _add_centre(value, error)
    if "harmonics" not in refused:
        _add_stiffness(film.scene, value, error)
    if "thrust" not in refused:
        _add_momentum(before, film, value, error, factor=factor)
        _add_sliding(before, film, value, error, factor=factor, least=least)
    else:
        for name in OUTPUTS["thrust"]:
            value.pop(name, None), error.pop(name, None)
    return Answered(Outputs(value=value, error=error, refused=refused), holds)


def _means(
    before: Sample, film: Sample, *, factor: float, left: float, tolerance: float
) -> tuple[dict[str, float], dict[str, float], bool, float]:
    """The answers that are means of the pressure with a weight, their errors, and if these hold.

    Last, the least change over its size that any answer of this pressure is taken to have.
    """
    coarse, fine = weights_of(before), weights_of(film)
    value = {name: film.mean(weight) for name, weight in fine.items()}
    size = {name: film.size(weight) for name, weight in fine.items()}
    error, holds, least = {}, True, 0.0
    # What rounding and the iteration leave is no reason for a finer grid.
    largest, narrowest = max(film.largest, -film.least), 1 - film.scene.closure()
    rounded = ROUNDED * ROUND_OFF * largest / narrowest
    for first_harmonics in (False, True):
        # Those that ask for harmonics are of first order in the amplitude, the others of second.
        alike = [n for n, weight in fine.items() if varies(weight) == first_harmonics and size[n]]
        change = {n: abs(value[n] - before.mean(coarse[n])) / size[n] for n in alike}
        most = max(change.values(), default=0.0)
        scale = max((abs(value[n]) / size[n] for n in alike), default=0.0)
        least = max(least, SHARE_OF_OTHERS * most)
        holds &= factor * most <= tolerance * scale + rounded + left
        for n in alike:
            error[n] = size[n] * (factor * max(change[n], SHARE_OF_OTHERS * most) + left)
    shown = [name for name in value if not name.startswith(GUARD)]
    return {n: value[n] for n in shown}, {n: error.get(n, 0.0) for n in shown}, holds, least


def _add_extremes(
    before: Sample,
    film: Sample,
    value: dict[str, float],
    error: dict[str, float],
    *,
    factor: float,
    left: float,
    least: float,
) -> None:
    ambient = film.scene.gas.ambient_pressure_pa
    pairs = {"largest": (before.largest, film.largest), "least": (before.least, film.least)}
    change = max(abs(coarse - fine) for coarse, fine in pairs.values())
    change = max(change, least * max(film.largest, -film.least))
    for name, (_, found) in pairs.items():
        value[f"{name}_overpressure"] = ambient * found
        error[f"{name}_overpressure"] = ambient * EXTREMES * (factor * change + left)


def _add_centre(value: dict[str, float], error: dict[str, float]) -> None:
    """Where the mean force acts; nowhere to be told without a force."""
    force, doubt = value[FORCE], error[FORCE]
    for name, moment, sign in (("centre_x", "moment_y", -1), ("centre_y", "moment_x", 1)):
        if abs(force) > 2 * doubt:
            value[name] = sign * value[moment] / force
            error[name] = (error[moment] + abs(value[name]) * doubt) / (abs(force) - doubt)


def _add_stiffness(scene: Scene, value: dict[str, float], error: dict[str, float]) -> None:
    """Force in phase with the motion of the gap and with its speed, over them."""
    speed = scene.hv_m * scene.actuator.angular_frequency_rad_per_s
    for name, part, per in (
        ("film_stiffness", "force_sin", scene.hv_m),
        ("film_damping", "force_cos", speed),
    ):
        value[name], error[name] = -value[part] / per, error[part] / per


def _add_momentum(
    before: Sample, film: Sample, value: dict[str, float], error: dict[str, float], *, factor: float
) -> None:
    """Half of what gas with inertia carries over the rim is taken from the finger."""
    if film.scene.gas.inertia != "included":
        return
    warm = _left_out_by_heat(film.scene)
    along_x, along_y = film.scene.finger.turned(1.0, 0.0)
    for which, (x, y) in enumerate(((along_x, along_y), (-along_y, along_x))):
        coarse, fine = before.momentum_n[which], film.momentum_n[which]
        doubt = factor * abs(fine - coarse) + warm * abs(fine)
        for name, share in (("thrust_x", x), ("thrust_y", y)):
            value[name] -= share * fine / 2
            error[name] += abs(share) * doubt / 2


def _left_out_by_heat(scene: Scene) -> float:
    """Share of that momentum that warm gas would change: twice its warming where it streams."""
    if scene.gas.heat != "included":
        return 0.0
    return 2 * float(Heat().numbers(scene)["heating"]) * scene.epsilon**2 / 20


def _add_sliding(
    before: Sample,
    film: Sample,
    value: dict[str, float],
    error: dict[str, float],
    *,
    factor: float,
    least: float,
) -> None:
    """The shear that a sliding surface makes by itself, which the whole thrust has too."""
    coarse, fine = _couette(before), _couette(film)
    slip = 2 * film.scene.slip_knudsen
    change = max(abs(fine - coarse), least * slip * abs(fine))  # slip knows the gas's density
    doubt = factor * change + ROUND_OFF * abs(fine)
    value["sliding_friction"], error["sliding_friction"] = fine, doubt
    turned = film.scene.finger.turned(1.0, 0.0)
    for name, share in zip(("thrust_x", "thrust_y"), turned, strict=True):
        value[name] += share * fine
        error[name] += abs(share) * doubt


def _couette(film: Sample) -> float:
    """μ U ⟨1/(h + 2 σ λ)⟩ times the area: of a wall that drags the gas, with slip at both walls."""
    scene = film.scene
    if scene.bearing_number == 0:
        return 0.0
    gap = scene.gap(film.x, film.y, film.phases)
    if scene.gas.rarefaction == "slip":
        density = (1 + film.overpressure) ** (1 / scene.gas.polytropic_exponent)
        gap = gap + 2 * scene.slip_knudsen / density
    shear = scene.gas.viscosity_pa_s * scene.finger.speed_x_m_per_s / scene.h0_m
    return float(shear * scene.finger.area_m2 * (film.weights @ (1 / gap)).mean())

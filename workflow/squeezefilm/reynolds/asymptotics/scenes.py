"""Scenes by expansions: which they are derived for, on which grids, and where they should hold."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics.composite import (
    AsymptoticForces,
    composite_expansion,
    edge_layer_expansion,
    expansion_points,
    small_amplitude_expansion,
)
from squeezefilm.reynolds.asymptotics.films import Films, expansion_axis, films_of
from squeezefilm.reynolds.needs import LeftOut, Needs
from squeezefilm.reynolds.periodic.resolution import nodes_for_profile
from squeezefilm.reynolds.terms import terms_of

Expand = Callable[[Films], AsymptoticForces]

# Scenes whose fields are held at a time; more would fall out of the caches.
BATCH = 256
# Squeeze numbers of the shorter side from which on the edge layer alone, and the composite on grids
# that resolve the layer, take less time than the periodic state. Processor time of a scene, 16 at
# random positions in a call (sinc, ε 0.05–0.7), in ms, by the edge layer and the periodic state: at
# 1e-2 and σ 2000, 2e4, 1e6 0.28, 0.23, 0.29 and 0.39, 0.59, 1.4; alone in its call 1.6 at any σ and
# 1.0, 1.2, 2.1; at 1e-4 and σ 2e4 0.3 and 5. By the composite at 1e-6 and σ 2000, 1e5 1.0, 5 and
# 0.7, 25.
EDGE_LAYER_FROM, COMPOSITE_FROM, COMPOSITE_TO_TOLERANCE = 2e4, 1e4, 1e-3
# With inertia, where a periodic state takes ten times as long, they pay wherever they hold.
# Motion so small, in ε² over the tolerance, that rounding hides a periodic state's force.
TINY = 1e-3


@dataclass(frozen=True)
class Expanded:
    """A scene's mean overpressure by an expansion, its error estimate, and the grid behind it."""

    mean: float
    error: float
    nx: int
    ny: int

    @property
    def flops(self) -> float:
        """Floating-point operations, roughly: two fast solves, with their grid error."""
        return 40.0 * self.nx * self.ny * (self.nx + self.ny)

    @property
    def relative_error(self) -> float:
        """The error over the mean; 0 for a film that is at rest and bears nothing."""
        if self.error == 0:
            return 0.0
        return self.error / abs(self.mean) if self.mean else inf

    @property
    def left_out(self) -> LeftOut:
        return LeftOut("time", f"the composite expansion is good to {self.relative_error:.1e}")

    def holds(self, tolerance: float) -> bool:
        """Whether the estimate meets a relative tolerance; ``nan`` does not."""
        return self.error <= tolerance * abs(self.mean)

    def status(self, tolerance: float) -> str:
        """``ok``, or what is wrong with the estimate."""
        if not isfinite(self.error):
            return "the error of the composite expansion is not known here"
        if not self.holds(tolerance):
            return f"the composite expansion is good to {self.relative_error:.1e} only"
        return "ok"


def not_derived_for(scene: Scene, needs: Needs) -> str:
    """Why there is no expansion of a scene's force; empty where there is."""
    what = "the composite expansion is derived for"
    if scene.finger.shape != "rectangle":
        return f"{what} rectangular pads"
    if scene.epsilon == 0:
        return f"{what} a surface that vibrates"
    unknown = [term.label for term in needs.terms if term.expansion_numbers(scene) is None]
    if unknown:
        return f"the composite expansion is not derived with {' and '.join(unknown)}"
    numbers = [term.label for term in needs.terms if term.expansion_numbers(scene)]
    if not scene.finger.gap.flat and numbers:
        return f"{what} a gap that is even at rest with {' and '.join(numbers)}"
    if scene.actuator.profile.is_complex and scene.gas.inertia == "included":
        return f"{what} a vibration in one phase with inertia"
    return ""


def composite(
    scenes: Sequence[Scene], needs: Sequence[Needs], *, tolerance: float, worth: bool
) -> dict[int, Expanded]:
    """The scenes' forces by the composite expansion, by index: the edge layer's alone where that
    holds the tolerance, else with the exact second order in ε where the gap is even at rest.

    Args:
        worth: to have those alone that hold the tolerance, of scenes whose periodic state should
            take longer.
    """
    known = [at for at, scene in enumerate(scenes) if not not_derived_for(scene, needs[at])]
    tried = [at for at in known if not worth or _edge_layer_pays(scenes[at], needs[at], tolerance)]
    found = expanded(edge_layer_expansion, scenes, needs, tried, tolerance=tolerance)
    more = [
        at
        for at in known
        if scenes[at].finger.gap.flat
        and not (at in found and found[at].holds(tolerance))
        and (not worth or _second_order_pays(scenes[at], needs[at], tolerance))
    ]
    # Of two large parts that cancel more digits are needed: with those of the tolerance alone the
    # grid's error was twice the tolerance (σ 1e5, 1e-6).
    joined = expanded(
        _with_second_order, scenes, needs, more, tolerance=tolerance / 10, layers=True
    )
    found |= {
        at: result
        for at, result in joined.items()
        if at not in found or result.error < found[at].error
    }
    if worth:
        return {at: result for at, result in found.items() if result.holds(tolerance)}
    return found


def _with_second_order(films: Films) -> AsymptoticForces:
    """The composite expansion; where layers are too thick for it, the second order in ε alone."""
    forces = composite_expansion(films)
    thick = ~np.isfinite(forces.error)
    if thick.any():
        second = small_amplitude_expansion(films.take(thick))
        forces.mean[thick], forces.error[thick] = second.mean, second.error
    return forces


def _edge_layer_pays(scene: Scene, needs: Needs, tolerance: float) -> bool:
    """Whether the edge layer's expansion may hold the tolerance and is worth its cost.

    The orders are those of the error estimates. Their factors are about the smallest that 2400
    random films had (ε 0.01–0.98, σ 0.1–1e6, sides 1:10 to 10:1), of the paper's sinc and of a
    piston. A profile between the two may be sent on although the expansion would do.
    """
    numbers = expansion_numbers(scene)
    if _slender_sigma(scene) < EDGE_LAYER_FROM and "reynolds" not in numbers:
        return False
    even = needs.uniform and scene.finger.gap.flat
    by_slopes = (0.3 if even else 100) * scene.sigma**-1.5
    return max(by_slopes, _of_corners(scene), _of_terms(scene, numbers)) <= tolerance


def _second_order_pays(scene: Scene, needs: Needs, tolerance: float) -> bool:
    """Whether the composite may hold the tolerance and is worth its cost."""
    square, numbers = scene.epsilon**2, expansion_numbers(scene)
    if square <= TINY * tolerance:
        return True
    if "reynolds" not in numbers and (
        _slender_sigma(scene) < COMPOSITE_FROM or tolerance > COMPOSITE_TO_TOLERANCE
    ):
        return False
    by_slopes = (3 if needs.uniform else 15) * square * scene.sigma**-1.5
    by_terms = 4 * square * _of_terms(scene, numbers)
    return max(by_slopes, _of_corners(scene), by_terms) <= tolerance


def _of_corners(scene: Scene) -> float:
    """Relative error by the pad's corners, which no expansion has, where the profile is large."""
    return float(scene.epsilon**2 / scene.sigma)


def _of_terms(scene: Scene, numbers: Mapping[str, float]) -> float:
    """Relative error of the edge layer's expansion by inertia and slip, roughly."""
    by_inertia = 15 * numbers.get("reynolds", 0.0) / scene.sigma
    return float(max(by_inertia, 0.3 * numbers.get("slip", 0.0) * scene.sigma**-0.5))


def _slender_sigma(scene: Scene) -> float:
    """Squeeze number of the shorter side."""
    return float(scene.sigma * min(1.0, scene.aspect) ** 2)


def expanded(
    expand: Expand,
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    which: Iterable[int],
    *,
    tolerance: float,
    layers: bool = False,
) -> dict[int, Expanded]:
    """One expansion of some of the scenes, by index; those with one grid together.

    Args:
        tolerance: of the grids.
        layers: whether these resolve the layers at the pad's edge.
    """
    groups: dict[tuple[int, int, bool, bool], list[int]] = defaultdict(list)
    for at in which:
        scene = scenes[at]
        sigma = scene.sigma if layers else 1.0
        # The error estimate uses every other node, which must resolve the profile too.
        nodes_x, nodes_y = nodes_for_profile(needs[at], tolerance=tolerance)
        nx = max(expansion_points(tolerance=tolerance, sigma=sigma), 2 * nodes_x + 1)
        ny = max(
            expansion_points(tolerance=tolerance, sigma=sigma * scene.aspect**2), 2 * nodes_y + 1
        )
        groups[nx, ny, scene.actuator.profile.is_complex, scene.finger.gap.flat].append(at)
    results = {}
    for (nx, ny, *_), group in groups.items():
        for start in range(0, len(group), BATCH):
            some = group[start : start + BATCH]
            forces = expand(_films([scenes[at] for at in some], nx=nx, ny=ny))
            for at, mean, error in zip(some, forces.mean, forces.error, strict=True):
                results[at] = Expanded(float(mean), float(error), nx, ny)
    return results


def _films(scenes: Sequence[Scene], *, nx: int, ny: int) -> Films:
    x, y = np.meshgrid(expansion_axis(nx).all_nodes, expansion_axis(ny).all_nodes, indexing="ij")
    places = {scene.place: scene.amplitude(x, y) for scene in scenes}
    numbers = [expansion_numbers(scene) for scene in scenes]
    flat = scenes[0].finger.gap.flat
    return films_of(
        np.array([scene.epsilon for scene in scenes]),
        np.array([scene.sigma for scene in scenes]),
        np.stack([places[scene.place] for scene in scenes]),
        aspect=np.array([scene.aspect for scene in scenes]),
        slip=np.array([each.get("slip", 0.0) for each in numbers]),
        reynolds=np.array([each.get("reynolds", 0.0) for each in numbers]),
        rest=None if flat else np.stack([scene.rest_gap(x, y) for scene in scenes]),
    )


def expansion_numbers(scene: Scene) -> dict[str, float]:
    """The numbers of a scene's terms that the expansions have: ``slip``, ``reynolds``."""
    return {
        name: value
        for term in terms_of(scene)
        for name, value in (term.expansion_numbers(scene) or {}).items()
    }

"""Mean forces without a single time step: expansions of the film equation, with their errors.

Every function takes a batch of B films (films.py) and returns mean gauge pressures, each with an
estimate of its absolute error:

    high_squeeze_limit         σ → ∞: one Poisson solve
    edge_layer_expansion       with the correction of order 1/√σ: one more
    small_amplitude_expansion  second order in ε, any σ: one complex Helmholtz solve
    composite_expansion        the last two together: exact in σ to ε², exact in ε to 1/√σ

An error has two parts: that of the expansion, estimated from the profile's slopes, its values on
the edge and at the corners, ε and σ; and that of the grid, the change against every other of its
nodes. Where an expansion does not apply the error is infinite.

The constants of the first part were fitted to periodic states converged to 1e-6: ε 0.01–0.98, σ
0.1–1e6, pistons and sincs with up to three nodes under the pad, aspects 0.2–5; each is about twice
what the worst film needed. Those of inertia were fitted to its second order in ε on such films and
to strips at any ε. Layers with inertia are known up to Re = 10 and excursions that depend on it
(edge_layer.py).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from math import isfinite, log10

import numpy as np

from squeezefilm.film.scene import Scene, Scenes, equal_row_groups
from squeezefilm.reynolds.asymptotics import core
from squeezefilm.reynolds.asymptotics.core import MeanPressureExpansion, SecondOrderMean
from squeezefilm.reynolds.asymptotics.films import (
    INERTIA_COMPOSITE_ERROR_FACTOR,
    Films,
    broadcast_over_field,
    expansion_axis,
    films_of,
    grid_error,
)
from squeezefilm.reynolds.periodic.resolution import nodes_for_profile
from squeezefilm.reynolds.plan import SolvePlan
from squeezefilm.reynolds.terms import Terms
from squeezefilm.reynolds.terms.gap import NonuniformGap

# Layers of width √(2/σ) must leave room on the shorter side: σ min(1, aspect)² at least this.
MIN_EXPANSION_SIGMA = 10.0
# At this the expansions in ε have their part of order ε² alone, to rounding.
SECOND_ORDER_PROBE_EPSILON = 1e-5
# Scenes whose fields are held at a time; more would fall out of the caches.
SCENES_PER_BATCH = 256
# Squeeze number of the shorter side from which on ``auto`` tries the expansions, to a tolerance of
# 1e-4; it goes with the root of a closer one. Of 24 random films (ε 0.05-0.7, sinc and piston) they
# hold 1e-4 at σ 1e4-1e5 in all, for 1.4 ms each instead of 16; 1e-6 at σ 1e5-1e6 in 12, and 1e6-1e7
# in 21, for 21 and 9 ms instead of 210 and 980.
THIN_LAYER_SIGMA, THIN_LAYER_SIGMA_TOLERANCE = 1e4, 1e-4
# Motion so small, in ε² over the tolerance, that rounding hides a periodic state's force.
MIN_RESOLVED_EPSILON_SQUARED = 1e-3


@dataclass(frozen=True)
class AsymptoticForces:
    """Mean gauge pressures over film and period in units of p0, and their errors; shape (B,).

    The force is p0 × area × ``mean``.
    """

    mean_pressure_ratio: np.ndarray
    pressure_ratio_error: np.ndarray


def expansion_nodes_per_axis(*, tolerance: float, sigma: np.ndarray) -> np.ndarray:
    """Points per direction that a profile about as smooth as the paper's sinc needs.

    The error estimate, not only the error, then meets the tolerance: every other node must do.

    Args:
        tolerance: relative error of the mean.
        sigma: squeeze number, times aspect² along y, where the method resolves the edge's layers
            (``small_amplitude_expansion`` and ``composite_expansion``); 1 for the others.
    """
    digits = log10(1 / tolerance)
    points = 2 * np.ceil(1 + digits + 0.36 * digits * np.maximum(sigma, 1.0) ** 0.25) + 1
    return points.astype(np.int64)


ExpansionFunction = Callable[[Films], AsymptoticForces]


def _slip_and_inertia_decorator(expand: ExpansionFunction) -> ExpansionFunction:
    """An expansion of films that may have slip, inertia or both.

    Both together: that with slip, and the change by inertia in a film without slip whose gas flows
    as freely, σ/(1 + slip) and Re (1 + 2 slip/3), as it is for small motion of dense gas.
    """

    @wraps(expand)
    def expand_with_slip_and_inertia(films: Films) -> AsymptoticForces:
        if not np.any((films.slip != 0) & (films.reynolds != 0)):
            return expand(films)
        none = np.zeros_like(films.slip)
        equivalent = replace(
            films,
            sigma=films.layer_squeeze_number,
            slip=none,
            reynolds=films.reynolds * (1 + 2 / 3 * films.slip),
        )
        slipping = expand(replace(films, reynolds=none))
        moving, still = expand(equivalent), expand(replace(equivalent, reynolds=none))
        change = moving.mean_pressure_ratio - still.mean_pressure_ratio
        error = np.maximum(
            slipping.pressure_ratio_error, moving.pressure_ratio_error
        ) + films.slip_remainder_fraction * np.abs(change)
        return AsymptoticForces(
            mean_pressure_ratio=slipping.mean_pressure_ratio + change,
            pressure_ratio_error=_infinite_where_missing(error),
        )

    return expand_with_slip_and_inertia


@_slip_and_inertia_decorator
def high_squeeze_limit(films: Films) -> AsymptoticForces:
    """Film at σ → ∞: PH = ψ(x, y), ψ²/2 + slip ψ harmonic, ⟨H³P²/2 + slip H²P⟩ kept to the edge.

    Under a gap G that is shaped at rest ∇·(G³ ∇(ψ²/G²)) = 0, and all else by the local ε s/G.
    With inertia core and edge are others (core.py). The error is the edge layer's correction
    and that one's error.
    """
    fine, coarse = _high_squeeze_expansion(films), _high_squeeze_expansion(films.coarser_films)
    error = (
        1.05 * np.abs(fine.layer_contribution)
        + films.layer_remainder
        + films.slip_remainder_fraction * fine.layer_magnitude_sum
    )
    error = error + grid_error(films, fine.pressure_integrand, coarse.pressure_integrand)
    return _asymptotic_forces(films, mean=films.pad_mean(fine.pressure_integrand), error=error)


@_slip_and_inertia_decorator
def edge_layer_expansion(films: Films) -> AsymptoticForces:
    """The high-squeeze limit with the edge's boundary layer, correct to 1/√σ (see edge_layer.py).

    With two quadrature components the next order is ε²/σ: the film then drives gas along itself.

    With slip the layer is taken to be √(1 + slip) thicker, which holds for small amplitude. With
    inertia the next order is ε²/σ (edge_layer.py), without it ε²/σ^(3/2).
    """
    fine, coarse = _high_squeeze_expansion(films), _high_squeeze_expansion(films.coarser_films)
    error = films.layer_remainder + films.slip_remainder_fraction * fine.layer_magnitude_sum
    rest = fine.layer_contribution - coarse.layer_contribution
    error = error + grid_error(
        films, fine.pressure_integrand, coarse.pressure_integrand, layer_change=rest
    )
    return _asymptotic_forces(
        films, mean=films.pad_mean(fine.pressure_integrand) + fine.layer_contribution, error=error
    )


@_slip_and_inertia_decorator
def small_amplitude_expansion(films: Films) -> AsymptoticForces:
    """Second order in ε at any σ: linear pressure p̂, then the mean flow that it drives.

    (1 + slip)∇²p̂ − iσp̂ = iσs and ∇²v = −(3/2)(1 + 2 slip/3)/(1 + slip) ∇·(s ∇Re p̂), zero on the
    edge; the mean is ε² ∫ v − |p̂|²/(4 (1 + slip)). With inertia, see core.py.
    """
    fine, coarse = _second_order_mean(films), _second_order_mean(films.coarser_films)
    square = films.epsilon**2
    error = films.second_order_remainder * films.pad_mean(
        np.abs(fine.flow_density) + np.abs(fine.loss_density)
    )
    error = error + grid_error(
        films,
        fine.flow_density - fine.loss_density,
        coarse.flow_density - coarse.loss_density,
        layer_change=fine.edge_driven_mean - coarse.edge_driven_mean,
    )
    mean = films.pad_mean(fine.flow_density - fine.loss_density) + fine.edge_driven_mean
    return AsymptoticForces(
        mean_pressure_ratio=square * mean,
        pressure_ratio_error=_infinite_where_missing(square * error),
    )


@_slip_and_inertia_decorator
def composite_expansion(films: Films) -> AsymptoticForces:
    """The edge layer's expansion with its part of order ε² replaced by the exact one.

    The additive composite of two expansions (Van Dyke, Perturbation Methods in Fluid Mechanics,
    1975): what is left is of order ε⁴/σ.
    """
    (fine, change), (coarse, _) = (
        _expansion_exact_to_order_2(films),
        _expansion_exact_to_order_2(films.coarser_films),
    )
    square = films.epsilon**2
    error = (
        2 * square * np.sqrt(films.narrowing_factor) * np.abs(change)
        + films.corner_remainder
        + square * films.narrowing_factor * films.streaming_remainder
        + INERTIA_COMPOSITE_ERROR_FACTOR * square * films.narrowing_factor * films.inertia_remainder
        + square * films.narrowing_factor * films.slip_remainder_fraction * fine.layer_magnitude_sum
    )
    rest = fine.layer_contribution - coarse.layer_contribution
    error = error + grid_error(
        films, fine.pressure_integrand, coarse.pressure_integrand, layer_change=rest
    )
    return _asymptotic_forces(
        films, mean=films.pad_mean(fine.pressure_integrand) + fine.layer_contribution, error=error
    )


def _expansion_exact_to_order_2(films: Films) -> tuple[MeanPressureExpansion, np.ndarray]:
    """An expansion with its part of order ε² exchanged for the exact one, and what that changes."""
    full, exact, square = (
        _high_squeeze_expansion(films),
        _second_order_mean(films),
        films.epsilon**2,
    )
    second = _high_squeeze_expansion(
        replace(films, epsilon=np.full_like(films.epsilon, SECOND_ORDER_PROBE_EPSILON))
    )
    density = (
        exact.flow_density
        - exact.loss_density
        - second.pressure_integrand / SECOND_ORDER_PROBE_EPSILON**2
    )
    layer = exact.edge_driven_mean - second.layer_contribution / SECOND_ORDER_PROBE_EPSILON**2
    changed = MeanPressureExpansion(
        full.pressure_integrand + broadcast_over_field(square) * density,
        full.layer_contribution + square * layer,
        full.layer_magnitude_sum,
    )
    return changed, square * (films.pad_mean(density) + layer)


def _high_squeeze_expansion(films: Films) -> MeanPressureExpansion:
    return (
        core.expand_with_inertia(films)
        if films.reynolds.any()
        else core.high_squeeze_expansion(films)
    )


def _second_order_mean(films: Films) -> SecondOrderMean:
    if films.static_gap is not None:
        raise ValueError("the second order in ε is derived for gaps that are uniform at rest")
    inertia = films.reynolds.any()
    return core.second_order_mean_with_inertia(films) if inertia else core.second_order_mean(films)


def _asymptotic_forces(films: Films, *, mean: np.ndarray, error: np.ndarray) -> AsymptoticForces:
    """Forces, with an infinite error where layers are too thick or the layer's table ends."""
    thin = films.decay_squeeze_number * np.minimum(1, films.aspect) ** 2 >= MIN_EXPANSION_SIGMA
    return AsymptoticForces(
        mean_pressure_ratio=mean,
        pressure_ratio_error=_infinite_where_missing(np.where(thin, error, np.inf)),
    )


def _infinite_where_missing(error: np.ndarray) -> np.ndarray:
    """Infinite where a number is missing."""
    return np.where(np.isfinite(error), error, np.inf)


@dataclass(frozen=True)
class ExpansionResults:
    """Mean gauge pressures of scenes by an expansion, error estimates, and the grids behind them.

    Attributes:
        rows: which of the scenes they are, (k,), as all others.
        mean_pressure_ratio, pressure_ratio_error: in units of p0.
        nx, ny: points of the grid.
    """

    scene_rows: np.ndarray
    mean_pressure_ratio: np.ndarray
    pressure_ratio_error: np.ndarray
    nx: np.ndarray
    ny: np.ndarray

    @classmethod
    def unknown_for_rows(cls, rows: np.ndarray | Sequence[int]) -> ExpansionResults:
        """Results that are not known yet."""
        rows = np.asarray(rows, dtype=np.int64)
        numbers, points = np.full((2, len(rows)), np.nan), np.zeros((2, len(rows)), dtype=np.int64)
        return cls(rows, *numbers, *points)

    def __getitem__(self, which: np.ndarray) -> ExpansionResults:
        return ExpansionResults(*[column[which] for column in vars(self).values()])

    def replace_rows(self, which: np.ndarray, others: ExpansionResults) -> None:
        """Write others in the place of some."""
        for name, column in vars(self).items():
            column[which] = getattr(others, name)

    @property
    def flops(self) -> np.ndarray:
        """Floating-point operations, roughly: two fast solves, with their grid error."""
        return 40.0 * self.nx * self.ny * (self.nx + self.ny)

    @property
    def relative_error(self) -> np.ndarray:
        """The error over the mean; 0 for a film that is at rest and bears nothing."""
        nothing = np.where(self.pressure_ratio_error == 0, 0.0, np.inf)
        return np.divide(
            self.pressure_ratio_error,
            np.abs(self.mean_pressure_ratio),
            out=nothing,
            where=self.mean_pressure_ratio != 0,
        )

    def accurate_mask(self, tolerance: float) -> np.ndarray:
        """Return where the estimate meets a relative tolerance; ``nan`` does not."""
        return np.asarray(self.pressure_ratio_error <= tolerance * np.abs(self.mean_pressure_ratio))

    def statuses(self, tolerance: float) -> list[str]:
        """``ok``, or what is wrong with the estimate."""
        return [
            "the error of the composite expansion cannot be estimated here"
            if not isfinite(error)
            else "ok"
            if holds
            else f"the composite expansion is accurate to {relative:.1e} only"
            for error, holds, relative in zip(
                self.pressure_ratio_error,
                self.accurate_mask(tolerance),
                self.relative_error,
                strict=True,
            )
        ]


EMPTY_EXPANSION_RESULTS = ExpansionResults.unknown_for_rows([])


def reasons_not_expanded(plan: SolvePlan) -> dict[int, str]:
    """The scenes of whose force there is no expansion, and why."""
    still = np.flatnonzero(plan.scenes.epsilon == 0).tolist()
    reason = "the composite expansion is derived for a surface that vibrates"
    return dict.fromkeys(still, reason) | plan.reasons_by_row(_reason_not_expanded)


def _reason_not_expanded(scene: Scene, terms: Terms) -> str:
    """Return the reason why no expansion is derived for a film and its terms, or an empty text."""
    what = "the composite expansion is derived for"
    if scene.pad.shape != "rectangle":
        return f"{what} rectangular pads"
    unknown = [term.label for term in terms if not term.SUPPORTS_EXPANSIONS]
    if unknown:
        return f"the composite expansion is not derived with {' and '.join(unknown)}"
    others = [term.label for term in terms if not isinstance(term, NonuniformGap)]
    if not scene.pad.gap.flat and others:
        return f"{what} a gap that is uniform at rest with {' and '.join(others)}"
    if scene.actuator.profile.is_complex and scene.gas.inertia == "included":
        return f"{what} one quadrature component with inertia"
    return ""


def composite_forces(
    plan: SolvePlan, *, tolerance: float, auto: bool, excluded: Collection[int] = ()
) -> ExpansionResults:
    """The scenes' forces by the composite expansion: the edge layer's alone where that holds the
    tolerance, else with the exact second order in ε where the gap is even at rest.

    Args:
        auto: to have those alone that hold the tolerance, of scenes with thin layers or tiny
            motion.
        but: scenes that are not to be expanded.
    """
    scenes = plan.scenes
    known = np.ones(len(scenes), dtype=bool)
    if auto:
        shorter = scenes.sigma * np.minimum(1.0, scenes.aspect) ** 2
        thin = THIN_LAYER_SIGMA * max(1.0, THIN_LAYER_SIGMA_TOLERANCE / tolerance) ** 0.5
        known = (shorter >= thin) | (scenes.epsilon**2 <= MIN_RESOLVED_EPSILON_SQUARED * tolerance)
        if not known.any():
            return EMPTY_EXPANSION_RESULTS
    known[[*excluded, *reasons_not_expanded(plan)]] = False
    rows = np.flatnonzero(known)
    by_layer = expand_scenes(edge_layer_expansion, plan, rows, tolerance=tolerance)
    flat = np.broadcast_to(scenes.film_value_column(lambda film: film.pad.gap.flat), len(scenes))
    more = np.flatnonzero(flat[rows] & ~by_layer.accurate_mask(tolerance))
    # Of two large parts that cancel more digits are needed: with those of the tolerance alone the
    # grid's error was twice the tolerance (σ 1e5, 1e-6).
    joined = expand_scenes(
        _composite_or_second_order, plan, rows[more], tolerance=tolerance / 10, layers=True
    )
    better = joined.pressure_ratio_error < by_layer.pressure_ratio_error[more]
    by_layer.replace_rows(more[better], joined[better])
    return by_layer[by_layer.accurate_mask(tolerance)] if auto else by_layer


def _composite_or_second_order(films: Films) -> AsymptoticForces:
    """The composite expansion; where layers are too thick for it, the second order in ε alone."""
    forces = composite_expansion(films)
    thick = ~np.isfinite(forces.pressure_ratio_error)
    if thick.any():
        second = small_amplitude_expansion(films.select_films(thick))
        forces.mean_pressure_ratio[thick], forces.pressure_ratio_error[thick] = (
            second.mean_pressure_ratio,
            second.pressure_ratio_error,
        )
    return forces


def expand_scenes(
    expand: ExpansionFunction,
    plan: SolvePlan,
    rows: np.ndarray | Sequence[int],
    *,
    tolerance: float,
    layers: bool = False,
) -> ExpansionResults:
    """One expansion of some of the scenes; those with one grid together.

    Args:
        tolerance: of the grids.
        layers: whether these resolve the layers at the pad's edge.
    """
    found = ExpansionResults.unknown_for_rows(rows)
    scenes = plan.scenes[found.scene_rows]
    sigma = scenes.sigma if layers else np.ones(len(scenes))
    # The error estimate uses every other node, which must resolve the profile too.
    nodes = 2 * nodes_for_profile(plan, tolerance=tolerance)[found.scene_rows] + 1
    for points, of_axis, at_least in zip(
        (found.nx, found.ny), (sigma, sigma * scenes.aspect**2), nodes.T, strict=True
    ):
        wanted = expansion_nodes_per_axis(tolerance=tolerance, sigma=of_axis)
        points[:] = np.maximum(wanted, at_least)
    # Films of one kind together: fields real or complex, gaps even at rest or not, inertia or not.
    kinds = [
        scenes.gas.inertia == "included",
        scenes.film_value_column(lambda film: film.actuator.profile.is_complex),
        scenes.film_value_column(lambda film: film.pad.gap.flat),
    ]
    columns = [np.broadcast_to(each, len(scenes)) for each in (found.nx, found.ny, *kinds)]
    for group in equal_row_groups(*columns):
        for start in range(0, len(group), SCENES_PER_BATCH):
            batch = group[start : start + SCENES_PER_BATCH]
            forces = expand(
                _films_of_scenes(scenes[batch], nx=found.nx[batch[0]], ny=found.ny[batch[0]])
            )
            found.mean_pressure_ratio[batch], found.pressure_ratio_error[batch] = (
                forces.mean_pressure_ratio,
                forces.pressure_ratio_error,
            )
    return found


def _films_of_scenes(scenes: Scenes, *, nx: int, ny: int) -> Films:
    x, y = np.meshgrid(expansion_axis(nx).all_nodes, expansion_axis(ny).all_nodes, indexing="ij")
    like = scenes.films[scenes.film_index[0]]
    amplitudes, which = scenes.evaluate_at_positions(
        lambda pad_positions: pad_positions.amplitude(x.ravel(), y.ravel())
    )
    rise_m = scenes.film_value_column(lambda film: film.pad.gap.rise_m(x, y))
    return films_of(
        scenes.epsilon,
        scenes.sigma,
        np.concatenate(amplitudes)[which].reshape(-1, *x.shape),
        aspect=scenes.aspect,
        slip=6 * scenes.slip_knudsen,
        reynolds=np.where(scenes.gas.inertia == "included", scenes.modified_reynolds, 0.0),
        rest_gap=None if like.pad.gap.flat else 1 + rise_m / scenes.h0_m[:, None, None],
    )

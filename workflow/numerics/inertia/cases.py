"""Stiff and extreme films with inertia of the gas, and how their forces are checked."""

from __future__ import annotations

from numerics.films import Film
from numerics.peers.fixed_grid import solve_on_grid
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid

GROUP = "inertia"
# Where waves steepen so much that no grid or no step of Newton's method may be enough.
STEEPEST = 2.0
NOT_CHECKED = "no state on a finer grid to check it with"


def films() -> list[tuple[Film, bool]]:
    """From a thick layer to a thin one, Re up to 50; with each, whether a sample has it."""
    sampled = {(20.0, 0.5, 0.5), (1e5, 0.1, 5.0), (583.0, 0.9, 50.0)}
    return [
        (
            Film(
                f"inertia, Re = {reynolds:g}, σ = {sigma:g}, ε = {epsilon:g}",
                epsilon,
                sigma,
                reynolds=reynolds,
            ),
            (sigma, epsilon, reynolds) in sampled,
        )
        for sigma in (1.0, 20.0, 583.0, 1e5)
        for epsilon in (0.1, 0.5, 0.9)
        for reynolds in (0.5, 5.0, 50.0)
    ]


def beyond(film: Film) -> str:
    """Why a film with inertia may be refused; empty where it must be solved."""
    if film.epsilon * film.reynolds > STEEPEST:
        return f"waves that steepen: ε Re above {STEEPEST:g}"
    if film.epsilon > 0.8 and film.reynolds > 0:
        return "inertia nearer to contact than 20 % of the gap"
    return ""


def on_a_finer_grid(
    film: Film, solution: Solution, *, tolerance: float, device: Device
) -> float | None:
    """The force, in p0 times the area, on a grid finer by a quarter; None if it has no state."""
    fold = film.fold
    grid = Grid(
        nx=_more(solution.nx // (1 + fold[0])),
        ny=_more(solution.ny // (1 + fold[1])),
        nt=_more(solution.nt),
        fold_x=fold[0],
        fold_y=fold[1],
    )
    states = solve_on_grid([film], grid=grid, tolerance=tolerance, device=device)
    return float(states.mean[0]) if states.status[0] == 0 else None


def _more(points: int) -> int:
    return points + 4 * max(1, round(points / 16))

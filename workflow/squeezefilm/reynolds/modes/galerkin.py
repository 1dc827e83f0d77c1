"""The periodic state under any pad: Galerkin's method in the pad's modes, in NumPy.

For what the kernels' grid does not know, elliptical outlines.

Unknown: the mass excess m = H(ρ − 1), zero on the rim, as a sum of modes φ_i (pad_modes.py) at
equidistant instants. With the flux's terms c_k H^(3−k) ∇g_k(P), dg_k/dP = ρ^(1−k), and the product
⟨·,·⟩ of the mean over the pad, the film equation asks of every mode

    −Σ_k c_k ⟨∇φ_i, H^(3−k) ∇Πg_k⟩ − σ d⟨φ_i, Hρ⟩/dT + Λ ⟨∂φ_i/∂X, Hρ⟩ = 0,

Π the projection on the modes. No derivative of the gap is needed, so that a gap of any shape enters
by its values alone. Newton's correction is a mass w = δm; in the modes times Fourier's harmonics
the operator D Δ − σ d/dT, D the mean diffusivity, is diagonal and preconditions GMRES.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.error_estimate import (
    ITERATION_SHARE,
    ROUND_OFF,
    UNKNOWN_FALL,
    error_text,
    estimate,
)
from squeezefilm.reynolds.grid import MOMENTS
from squeezefilm.reynolds.modes.film_in_modes import FilmInModes
from squeezefilm.reynolds.modes.pad_modes import PadGrid, PadModes, pad_modes
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.gap_numbers import gap_numbers
from squeezefilm.reynolds.periodic.resolution import (
    MOST_TIME,
    first_grid,
    profile_fall,
)
from squeezefilm.reynolds.solution import solution_of
from squeezefilm.reynolds.spectral import period
from squeezefilm.reynolds.terms import (
    Terms,
    first_reason,
    state_refused,
    stiffness_of,
)

METHOD = "periodic-modes"
# Estimates are this many times those of the grids. Without it 2 of 60 forces of random pads were
# off by 1.2 and 1.9 times their estimate, for few modes agree by chance; with it 208 were off
# by 0.48 of it at most.
MARGIN = 2.0
MOST_NEWTON = 40
MOST_KRYLOV = 120
LARGEST_BYTES = 2**30


@dataclass(frozen=True)
class Resolution:
    """Degree of the modes and number of instants."""

    pad: PadGrid
    instants: int

    @property
    def fits(self) -> bool:
        """Whether the modes and the Krylov vectors take no more memory than is allowed."""
        points = self.pad.points[0] * self.pad.points[1] / self.pad.folds
        matrices = 3 * 8 * points * self.pad.modes if self.pad.shape == "ellipse" else 0
        fields = 8 * self.instants * (20 * points + (MOST_KRYLOV + 1) * self.pad.modes)
        return matrices + fields <= LARGEST_BYTES and self.instants <= MOST_TIME

    @property
    def finer(self) -> Resolution:
        """The next resolution, about a fifth more of each."""
        degree = self.pad.degree + 2 * max(2, round(self.pad.degree / 10))
        instants = self.instants + 4 * max(1, round(self.instants / 20))
        return Resolution(replace(self.pad, degree=degree), instants)

    @property
    def flops(self) -> float:
        """Floating-point operations of one Krylov iteration's products."""
        return 6 * self.pad.flops * self.instants


@dataclass
class _State:
    """A state on one resolution and how it was reached; ``pressure`` is P − 1, (Q, instants)."""

    modes: PadModes
    mass: np.ndarray
    pressure: np.ndarray
    largest: float
    thinnest: float
    residual: float
    newton_steps: int
    krylov_iterations: int
    failure: str = ""

    @property
    def moments(self) -> np.ndarray:
        """Lowest cosine moments of the mean overpressure; the first is its mean."""
        x, y = (
            np.cos(2 * np.pi * np.outer(np.arange(MOMENTS), place))
            for place in (self.modes.x, self.modes.y)
        )
        moments: np.ndarray = (x * self.modes.weights * self.pressure.mean(axis=1)) @ y.T
        return moments

    def carried_to(self, finer: Resolution) -> np.ndarray:
        """The mass on a finer resolution, a first guess there."""
        in_time = period(self.mass.shape[1]).interpolation_to(period(finer.instants))
        return self.modes.carry(self.mass, pad_modes(finer.pad)) @ in_time.T


def solve_in_modes(
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    *,
    tolerance: float,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """The periodic state of each scene; the arguments are those of ``solver.solve``."""
    solutions = []
    for scene, need in zip(scenes, needs, strict=True):
        solutions.append(_solve(scene, need, tolerance=tolerance))
        report(1)
    return solutions


def pressure_at(
    scene: Scene, *, x: np.ndarray, y: np.ndarray, instants: int, tolerance: float
) -> np.ndarray | None:
    """Overpressure P − 1 over a period at places x, y in [0, 1] across any pad, each shape (N,).

    Shape (N, instants), at equidistant instants; None where this method finds no state. Resolutions
    are refined until none of these values changes by more than ``tolerance`` of the largest.
    """
    times = period(instants)
    gap = scene.gap(x, y, times.nodes)
    needs = needs_of(scene)
    terms = needs.terms
    resolution = first_resolution(scene, needs, tolerance=tolerance)
    state: _State | None = None
    before: np.ndarray | None = None
    while resolution.fits and not _unknown(terms, scene):
        guess = state.carried_to(resolution) if state is not None else None
        state = _periodic_state(scene, resolution, guess=guess, tolerance=tolerance)
        if state.failure:
            break
        in_time = period(resolution.instants).interpolation_to(times)
        excess = state.modes.at(x, y, state.mass @ in_time.T)
        pressure: np.ndarray = np.expm1(scene.gas.polytropic_exponent * np.log1p(excess / gap))
        if before is not None and np.abs(pressure - before).max() <= tolerance * np.ptp(pressure):
            return pressure
        before, resolution = pressure, resolution.finer
    return None


def wants_modes(scene: Scene) -> bool:
    """Whether the kernels' grid does not know this finger."""
    return scene.finger.shape != "rectangle"


def solved_in_modes(scene: Scene) -> bool:
    """Whether such a finger's force is found in modes, not on a grid in its own coordinates."""
    return wants_modes(scene) and scene.bearing_number != 0


def refused(scene: Scene, needs: Needs, *, tolerance: float) -> str:
    """Why a scene has no force in modes, as far as that is known before solving; else empty."""
    if unknown := _unknown(needs.terms, scene):
        return unknown
    first = first_resolution(scene, needs, tolerance=tolerance)
    for resolution in (first, first.finer):  # it takes two to know the error
        if not resolution.fits:
            return too_many(resolution)
    return ""


def _unknown(terms: Terms, scene: Scene) -> str:
    if scene.finger.contour:
        return "a finger with an outline from a file does not slide: its modes are not known"
    return first_reason(term.refused_in_modes(scene) for term in terms)


def too_many(resolution: Resolution) -> str:
    return f"tolerance not reached: modes of degree {resolution.pad.degree} are too many"


def first_resolution(scene: Scene, needs: Needs, *, tolerance: float) -> Resolution:
    """As fine as the rectangle's first grid: a degree for each node across."""
    numbers = gap_numbers(scene)
    grid = first_grid(**numbers, aspect=scene.aspect, needs=needs, tolerance=tolerance)
    degree = max(8, 2 * round(max(grid.x.full_points, grid.y.full_points) / 2))
    pad = PadGrid(scene.finger.shape, degree, scene.aspect, needs.fold_x, needs.fold_y)
    return Resolution(pad, grid.nt)


def _solve(scene: Scene, needs: Needs, *, tolerance: float) -> Solution:
    resolution = first_resolution(scene, needs, tolerance=tolerance)
    before: _State | None = None
    degree = 0
    newton = krylov = 0
    work = 0.0
    status, force, error = "", np.nan, np.nan
    reached = "the error is not known"
    residual = 0.0
    while True:
        if not resolution.fits:
            status = f"{too_many(resolution)}; {reached}"
            break
        guess = before.carried_to(resolution) if before is not None else None
        state = _periodic_state(scene, resolution, guess=guess, tolerance=tolerance)
        newton += state.newton_steps
        krylov += state.krylov_iterations
        work += (state.newton_steps + state.krylov_iterations) * resolution.flops
        residual = state.residual
        if state.failure:
            status = f"{state.failure} (modes up to degree {resolution.pad.degree})"
            break
        if refused_state := state_refused(scene, needs.terms, thinnest=state.thinnest):
            status = refused_state
            break
        mean = float(state.moments[0, 0])
        if before is not None:
            narrowest = 1 - scene.closure()
            found = estimate(
                change=np.abs(state.moments - before.moments).max(),
                # A mass error w moves the pressure by about n w/H.
                left=stiffness_of(scene, needs.terms) * residual / narrowest,
                largest=state.largest,
                narrowest=narrowest,
                mean=mean,
                tolerance=tolerance,
                fall=max(UNKNOWN_FALL, _profile_fall(needs, degree, resolution, tolerance)),
                margin=MARGIN,
            )
            known, allowed = float(found.error), float(found.allowed)
            if known <= allowed:
                status, force, error = "ok", mean, known
                break
            reached = error_text(known, allowed=allowed, force=mean)
        before, degree = state, resolution.pad.degree
        resolution = resolution.finer
    return solution_of(
        scene,
        mean=force,
        error=error,
        left_out=needs.halves_left_out + needs.terms_left_out,
        status=status,
        method=METHOD,
        nx=resolution.pad.points[0],
        ny=resolution.pad.points[1],
        nt=resolution.instants,
        newton_steps=newton,
        krylov_iterations=krylov,
        residual=residual,
        work=work,
    )


def _profile_fall(needs: Needs, before: int, resolution: Resolution, tolerance: float) -> float:
    """Factor by which what a degree misses of the profile falls from one to the next."""
    coarse, fine = (before, before), (resolution.pad.degree, resolution.pad.degree)
    return profile_fall(needs, coarse, fine, tolerance=tolerance)


def _periodic_state(
    scene: Scene, resolution: Resolution, *, guess: np.ndarray | None, tolerance: float
) -> _State:
    """Newton's method with GMRES on one resolution, from a guess or from rest."""
    from scipy.sparse.linalg import LinearOperator, gmres

    modes, time = pad_modes(resolution.pad), period(resolution.instants)
    film = FilmInModes(scene, modes, time.nodes)
    shape = len(modes.eigenvalues), resolution.instants
    mass = np.zeros(shape) if guess is None else guess
    harmonics = 1j * np.arange(resolution.instants // 2 + 1)
    harmonics[-1] = 0  # the last cosine has no rate on the instants

    def rate(values: np.ndarray) -> np.ndarray:
        spectrum = harmonics * np.fft.rfft(values, axis=1)
        return scene.sigma * np.fft.irfft(spectrum, n=resolution.instants, axis=1)

    newton = krylov = 0
    size, failure = np.inf, "Newton's method did not converge"
    with np.errstate(all="ignore"):
        while newton <= MOST_NEWTON:
            film.set_state(mass)
            symbol = -film.diffusivity * modes.eigenvalues[:, None] - scene.sigma * harmonics

            def precondition(values: np.ndarray, symbol: np.ndarray = symbol) -> np.ndarray:
                spectrum = np.fft.rfft(values, axis=1) / symbol
                return np.fft.irfft(spectrum, n=resolution.instants, axis=1)

            def product(flat: np.ndarray) -> np.ndarray:
                change = flat.reshape(shape)
                return precondition(film.respond(change) - rate(change)).ravel()

            right = -precondition(film.balance() - rate(mass)).ravel()
            size = float(np.sqrt(right @ right / resolution.instants))
            if not np.isfinite(size):
                failure = "the pressure became infinite"
                break
            force = film.mean_overpressure
            share = ITERATION_SHARE * tolerance * (1 - scene.closure())
            goal = max(share * abs(force), ROUND_OFF * float(np.abs(film.pressure).max()))
            if size <= goal or size == 0:
                failure = ""
                break
            target = max(0.3 * goal, min(0.1 * size, size**2))
            norms: list[float] = []
            step, _ = gmres(
                LinearOperator((right.size, right.size), matvec=product, dtype=float),
                right,
                rtol=target / size,
                restart=MOST_KRYLOV,
                maxiter=1,
                callback=norms.append,
                callback_type="pr_norm",
            )
            newton, krylov = newton + 1, krylov + len(norms)
            change = step.reshape(shape)
            mass = mass + film.safe_share(change) * change
    return _State(
        modes=modes,
        mass=mass,
        pressure=film.pressure,
        largest=float(np.abs(film.pressure).max()),
        thinnest=float((film.density * film.gap).min()),
        residual=size,
        newton_steps=newton,
        krylov_iterations=krylov,
        failure=failure,
    )

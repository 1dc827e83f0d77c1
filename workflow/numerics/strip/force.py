"""The mean force on a strip by each equation, every force from two grids."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from numerics.peers.yardstick import FloatArray
from numerics.strip.averaged import AveragedFilm, heat_source
from numerics.strip.film import HeatedGas, Profile, StripFilm, sinc_profile
from numerics.strip.grid import StripGrid, strip_grid
from numerics.strip.heated import HeatedFilm
from numerics.strip.resolved import Entrance, ResolvedFilm
from squeezefilm.io.errors import InputError

Inertia = Literal["none", "first-order", "one-mode", "resolved"]
Heat = Literal["none", "first-order", "one-mode", "resolved"]
AIR = HeatedGas()
ITERATION = 1e-8
"""Tolerance of the iterations, on the state, in units of epsilon^2, as large as a mean force."""
COARSE = 0.75
"""Points and instants of the coarser grid, in those of the finer."""
SAFETY = 2.0
"""Error of the finer grid over the distance of the two, bounded for orders above 1.4."""


@dataclass(frozen=True)
class StripForce:
    """A mean force on a strip, in p0 l0 per length.

    Attributes:
        force: of the finer grid.
        error: estimate, from how far the coarser one is.
        nx, nz, nt: points across half of the strip and half of the gap, and instants.
    """

    force: float
    error: float
    nx: int
    nz: int
    nt: int

    @property
    def relative_error(self) -> float:
        return self.error / abs(self.force)


def grid_for(film: StripFilm, *, refinement: float = 1.0) -> StripGrid:
    """Points for the layer of width sqrt(2/sigma) at the rim, instants for the film's harmonics.

    Harmonics fall as the powers of epsilon / (1 + sqrt(1 - epsilon^2)), and inertia makes waves
    steeper.
    """
    ratio = film.epsilon / (1 + math.sqrt(1 - film.epsilon**2))
    nx = 8 + 2.4 * film.sigma**0.25
    nt = 9 + 16 / -math.log(ratio) + film.epsilon * film.reynolds
    return strip_grid(
        nx=math.ceil(refinement * nx),
        nz=math.ceil(6 * refinement),
        nt=2 * math.ceil(refinement * nt / 2) + 1,
    )


@dataclass(frozen=True)
class StripOnGrid:
    """A strip's mean force on one grid by any of the equations; what they share is solved once.

    Attributes:
        gas: what heat depends on.
        entrance: what is said of gas streaming in, of a resolved film.
    """

    film: StripFilm
    grid: StripGrid
    gas: HeatedGas = AIR
    entrance: Entrance = "local"

    def force(self, *, inertia: Inertia, heat: Heat) -> float:
        """In p0 l0 per length. Raises RunError where Newton's method finds no periodic state."""
        if heat == "one-mode":
            return self._warm(inertia)
        force = self._with_inertia(inertia, resolved_heat=heat == "resolved")
        return force + self._heat if heat == "first-order" else force

    @property
    def tolerance(self) -> float:
        return ITERATION * self.film.epsilon**2

    @cached_property
    def _still(self) -> AveragedFilm:
        return AveragedFilm(self.film, self.grid, inertia=False)

    @cached_property
    def _rest(self) -> FloatArray:
        """Of the Reynolds equation, where the others start."""
        return self._still.solve(tolerance=self.tolerance).state

    @cached_property
    def _heat(self) -> float:
        source = heat_source(self._still, self._rest, self.gas)
        return self._still.response(self._rest, source)

    @cached_property
    def _moving(self) -> AveragedFilm:
        return AveragedFilm(self.film, self.grid, inertia=True)

    @cached_property
    def _one_mode(self) -> FloatArray:
        return self._moving.solve(tolerance=self.tolerance, start=self._rest).state

    def _warm(self, inertia: Inertia) -> float:
        moves = inertia == "one-mode"
        film = HeatedFilm(self._moving if moves else self._still, self.gas)
        start = self._one_mode if moves else self._rest
        return film.force(film.solve(start, tolerance=self.tolerance).state)

    def _with_inertia(self, inertia: Inertia, *, resolved_heat: bool) -> float:
        still = self._still
        if inertia == "one-mode":
            return self._moving.force(self._one_mode)
        if inertia == "resolved":
            gas = self.gas if resolved_heat else None
            resolved = ResolvedFilm(self.film, self.grid, gas, self.entrance)
            start = resolved.from_averaged(*still.unpacked(self._rest))
            return resolved.force(resolved.solve(start, tolerance=self.tolerance).state)
        force = still.force(self._rest)
        if inertia == "first-order":
            source = self.film.reynolds * still.inertial(self._rest)
            force += still.response(self._rest, source)
        return force


def two_grids(
    film: StripFilm, *, gas: HeatedGas = AIR, entrance: Entrance = "local", refinement: float = 1.0
) -> tuple[StripOnGrid, StripOnGrid]:
    """The coarser and the finer grid that a force is estimated from."""
    coarse, fine = (
        StripOnGrid(film, grid_for(film, refinement=share * refinement), gas, entrance)
        for share in (COARSE, 1.0)
    )
    return coarse, fine


def force_on(grids: tuple[StripOnGrid, StripOnGrid], *, inertia: Inertia, heat: Heat) -> StripForce:
    """The finer grid's force, with an error from the coarser one's."""
    coarse, fine = (each.force(inertia=inertia, heat=heat) for each in grids)
    grid = grids[-1].grid
    return StripForce(
        force=fine,
        error=SAFETY * abs(fine - coarse),
        nx=len(grid.x.x) - 1,
        nz=len(grid.zeta.x) - 1,
        nt=grid.instants,
    )


def strip_force(
    *,
    epsilon: float,
    sigma: float,
    reynolds: float,
    inertia: Inertia = "none",
    heat: Heat = "none",
    gas: HeatedGas = AIR,
    entrance: Entrance = "local",
    profile: Profile = sinc_profile,
    refinement: float = 1.0,
) -> StripForce:
    """The mean force on an infinitely long strip under a profile even about its middle.

    Args:
        inertia: none (the Reynolds equation), first-order in Re, one-mode (a parabola across the
            gap) or resolved across the gap.
        heat: none, first-order in Re (added to any of the others), one-mode (a parabola across the
            gap, with inertia none or one-mode) or resolved, which asks for resolved inertia.
        entrance: what is said of gas streaming in, of the resolved film (see `resolved`).
        refinement: of both grids.

    Raises:
        InputError: for resolved heat without resolved inertia, one mode of heat with inertia that
            has not one or none, or an amplitude that closes the gap.
        RunError: where Newton's method finds no periodic state.
    """
    if not 0 < epsilon < 1:
        raise InputError(f"an amplitude of {epsilon:g} mean gaps")
    if heat == "resolved" and inertia != "resolved":
        raise InputError("heat is resolved together with the velocity alone")
    if heat == "one-mode" and inertia not in ("none", "one-mode"):
        raise InputError("one mode of heat goes with one mode of velocity, or with no inertia")
    film = StripFilm(epsilon=epsilon, sigma=sigma, reynolds=reynolds, profile=profile)
    grids = two_grids(film, gas=gas, entrance=entrance, refinement=refinement)
    return force_on(grids, inertia=inertia, heat=heat)

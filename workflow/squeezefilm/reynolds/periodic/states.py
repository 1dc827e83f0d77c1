"""What the device says of scenes on a grid (periodic.cl)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from squeezefilm.reynolds.grid import Grid

# How an iteration ends: the kernel's names, and what is said of it.
ENDINGS = {
    "CONVERGED": "ok",
    "STALLED": "Newton's method did not converge",
    "NOT_FINITE": "the pressure became infinite",
}
STATUS = tuple(ENDINGS.values())

# What the device says of a scene on a grid beside its overpressure: a row of its results.
SAID = np.dtype(
    [
        *((name, np.float64) for name in ("mean", "residual", "largest", "lowest", "thinnest")),
        *((name, np.float64) for name in ("moment", "size")),
        *((name, np.int64) for name in ("status", "newton_steps", "krylov_iterations")),
    ]
)


@dataclass(frozen=True)
class State:
    """The periodic state of one scene on one grid, on the host.

    Attributes:
        unknowns: p = P − 1 in units of the ambient pressure and the terms' own unknowns, shape
            (fields, nx, ny, nt).
    """

    grid: Grid
    unknowns: np.ndarray


@dataclass(frozen=True)
class States:
    """What the device returns, one entry per scene.

    Attributes:
        kept: the unknowns, or none where the batch does not ask for them.
        mean_in_time: overpressure averaged over the period, shape (scenes, nx, ny).
        said: rows of what is said of the scenes, the properties' values.
    """

    kept: np.ndarray | None
    mean_in_time: np.ndarray
    said: np.ndarray

    @property
    def unknowns(self) -> np.ndarray:
        """p = P − 1 on the grid and the terms' own unknowns, shape (scenes, fields, nx, ny, nt)."""
        if self.kept is None:
            raise ValueError("the batch did not ask for the states on this grid")
        return self.kept

    @property
    def overpressure(self) -> np.ndarray:
        """p, shape (scenes, nx, ny, nt)."""
        return self.unknowns[:, 0]

    @property
    def mean(self) -> np.ndarray:
        """Mean of p over film and period, the force in units of p0 × area."""
        return self.said["mean"]

    @property
    def residual(self) -> np.ndarray:
        """Preconditioned residual, an estimate of the mass error left by the iteration."""
        return self.said["residual"]

    @property
    def largest(self) -> np.ndarray:
        """Largest |p|."""
        return self.said["largest"]

    @property
    def lowest(self) -> np.ndarray:
        """Smallest pressure P, on the last grid of a launch; NaN on others."""
        return self.said["lowest"]

    @property
    def thinnest(self) -> np.ndarray:
        """Smallest product ρ H, by which the local Knudsen number grows, likewise; of a gas that
        is not rarefied NaN."""
        return self.said["thinnest"]

    @property
    def moment(self) -> np.ndarray:
        """Largest moment of the change of the means from the first guess (error_estimate.py)."""
        return self.said["moment"]

    @property
    def size(self) -> np.ndarray:
        """Mean of that change's magnitude."""
        return self.said["size"]

    @property
    def status(self) -> np.ndarray:
        """Index into STATUS."""
        return self.said["status"]

    @property
    def newton_steps(self) -> np.ndarray:
        return self.said["newton_steps"]

    @property
    def krylov_iterations(self) -> np.ndarray:
        return self.said["krylov_iterations"]

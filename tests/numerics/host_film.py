"""Films on the host, apart from the kernels: fields, means and the film equation's residual."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.quantities import fields
from squeezefilm.solution import Solution


class Fields(fields.Fields):
    """Films of like terms on one grid, with derivatives that the equation alone has."""

    @cached_property
    def gap_rate(self) -> np.ndarray:
        """∂H/∂T."""
        return self.t_derivative(self.gap)

    def gradient(self, values: np.ndarray) -> np.ndarray:
        return np.stack([self.x_derivative(values), self.y_derivative(values)])

    def on_all_nodes(self, values: np.ndarray) -> np.ndarray:
        """Values at the unknowns with zeros on the edge."""
        everywhere = np.zeros(self.gap.shape)
        everywhere[self.inner] = values
        return everywhere


def fields_of(scenes: Sequence[Scene], solutions: Sequence[Solution], *, grid: int = -1) -> Fields:
    """The films of ``alike`` scenes, by default on the finer grid."""
    states = [solution.states[grid] for solution in solutions]
    return Fields.of(scenes, states[0].grid, np.stack([each.unknowns for each in states]))


def residual(films: Fields) -> np.ndarray:
    """Return the residual of the film equation at the unknowns.

    The residual is ∇·(W H³ρ ∇P) − σ ∂(Hρ)/∂T − Λ ∂(Hρ)/∂X, W the flow over a viscous gas',
    of shape (scenes, nx, ny, nt).
    """
    flow = films.divergence(films.slope * (films.mobility * films.mass))
    moved = films.sigma * films.area * films.t_derivative(films.mass)
    moved += films.equation_numbers("bearing", absent=0.0) * films.pad_x_derivative(films.mass)
    return np.asarray((flow - moved)[films.inner])

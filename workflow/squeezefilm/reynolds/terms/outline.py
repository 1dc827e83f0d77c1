"""A smooth outline that is no rectangle: the area behind each point weighs what changes in time.

In the conformal coordinates of the outline (film/outline.py) the equation times that area has the
rectangle's form but for this weight J/J̄ of σ d(Hρ)/dT; the term adds what is more than 1 of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.film.symmetry import axisymmetric_mask
from squeezefilm.reynolds.spectral import even_and_odd_matrices
from squeezefilm.reynolds.terms.term import NamedArrays, Term

if TYPE_CHECKING:
    from squeezefilm.reynolds.grid import Grid

# How far points may lie off an outline that is exact, over its length.
EXACT_OUTLINE_TOLERANCE = 1e-9


class SmoothOutline(Term):
    label = "smooth outline"
    NAME = "outline"
    KERNEL_FILE = "terms/outline_over_period.cl"
    KERNEL_HOOKS: ClassVar[tuple[str, ...]] = ("residual", "response")
    SUPPORTS_SINGLE_PRECISION = True
    TIME_MATRIX_PRODUCT_COUNT = 1

    @classmethod
    def of(cls, scene: Scene) -> SmoothOutline | None:
        if not scene.pad.smooth_outline:
            return None
        return RadialFilm() if axisymmetric_mask(scene.pad_positions)[0] else cls()

    @classmethod
    def note(cls, scene: Scene) -> str:
        contour = scene.pad.contour
        if contour is None or contour.point_scatter < EXACT_OUTLINE_TOLERANCE:
            return ""
        off_um = contour.point_scatter * scene.pad.length_x_m * 1e6
        return (
            f"the outline's points lie up to {off_um:.2g} µm off it: what that leaves open of the "
            "force is not in its error"
        )

    def matrices(self, grid: Grid, *, aspect: float) -> NamedArrays:
        """The area, and modes in space by which its mean along an axis is preconditioned exactly.

        With α the mean of J along one axis and λ an eigenvalue of the second derivative there, the
        modes of D Δ − σ α A ∂/∂T along the other one are those of (∂² + λ)/α, whatever D and A. The
        axis is that along which J varies less.
        """
        outline, area = grid.outline, np.asarray(grid.area_ratio_at(grid.x.nodes))
        assert outline
        x, y = grid.x, grid.y
        (length_x, length_y), weights = (
            grid.axis_lengths(aspect),
            x.quadrature_weights / x.quadrature_weights.sum(),
        )
        second = x.second_derivative / length_x**2, y.second_derivative_parts / length_y**2
        if outline.jacobian_varies_more_with_nu:
            mean, own, weights = weights @ area, second[1], y.quadrature_weights
            others = x.even_odd_modes[0] / length_x**2
        else:
            mean, own, weights = area @ y.quadrature_weights, second[0], x.quadrature_weights
            others = y.even_odd_modes[0] / length_y**2
        operators = own + others[:, None, None] * np.eye(len(own))
        if outline.jacobian_varies_more_with_nu:
            values, vectors, inverse = _modes_of_symmetric_operators(operators, mean)
        else:
            values, vectors, inverse = _modes_of_real_operators(
                operators / mean[:, None], in_halves=x.uses_even_odd_parts
            )
        # Of unit mean square over the pad.
        size = np.sqrt(weights * mean * grid.inverse_mean_area @ vectors**2)
        evened = np.broadcast_to(
            mean if outline.jacobian_varies_more_with_nu else mean[:, None], area.shape
        )
        return {
            "stretch": area - 1,
            "uneven": area - evened,
            "evened": evened,
            "modes_by": vectors / size[:, None],
            "to_modes_by": inverse * size[..., None] / mean,
            "eigenvalues": values if outline.jacobian_varies_more_with_nu else values.T,
        }


class RadialFilm(SmoothOutline):
    """A disc on an axisymmetric film: its radius is the only axis, and has its own modes."""

    NAME = "radius"
    KERNEL_FILE = ""
    KERNEL_HOOKS = ()
    TIME_MATRIX_PRODUCT_COUNT = 0

    def matrices(self, grid: Grid, *, aspect: float) -> NamedArrays:
        return {}


def _modes_of_symmetric_operators(
    operators: np.ndarray, mean: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return eigenvalues, vectors and their inverse of symmetric operators over a positive mean.

    Those of α^(−1/2) S α^(−1/2) are orthogonal, so that none of nearly equal modes has to be
    inverted, whatever the number of threads makes of their rounding.
    """
    root = np.sqrt(mean)
    values, orthogonal = np.linalg.eigh(operators / np.multiply.outer(root, root))
    return values, orthogonal / root[:, None], orthogonal.swapaxes(-1, -2) * root


def _modes_of_real_operators(
    operators: np.ndarray, *, in_halves: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return eigenvalues, vectors and their inverse of operators with real eigenvalues.

    Args:
        in_halves: modes of all of x, the even ones, then the odd ones.
    """
    parts = even_and_odd_matrices(operators) if in_halves else operators[None]
    values, vectors = (array.real for array in np.linalg.eig(parts))
    near = np.concatenate(vectors, axis=-1)
    mirrored = [sign * array[:, ::-1] for sign, array in zip((1, -1), vectors, strict=False)]
    far = [np.concatenate(mirrored, axis=-1)] * in_halves
    vectors = np.concatenate([near, *far], axis=1)
    return np.concatenate(values, axis=-1), vectors, np.linalg.inv(vectors)

"""Collocation across the film and over the period: nodes, derivatives, quadrature, symmetry."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

# How steeply the harmonics that are kept of a function of time end.
HARMONICS_CUTOFF_STEEPNESS = 8


@dataclass(frozen=True)
class Axis:
    """Chebyshev collocation on [0, 1] for functions that vanish at both ends.

    A folded axis holds the first half of the interior nodes only and represents functions that
    are even about 1/2; its ``unknown_count`` then stand for twice as many.

    Attributes:
        unknown_count: number of unknowns along the axis, n.
        folded: whether the axis stands for its mirror image too.
    """

    unknown_count: int
    folded: bool

    @property
    def full_point_count(self) -> int:
        """Interior nodes of the unfolded axis."""
        return 2 * self.unknown_count if self.folded else self.unknown_count

    @cached_property
    def all_nodes(self) -> np.ndarray:
        """Chebyshev–Lobatto nodes on [0, 1], both ends included, shape (full_point_count + 2,)."""
        order = self.full_point_count + 1
        return (1 - np.cos(np.pi * np.arange(order + 1) / order)) / 2

    @property
    def inner_slice(self) -> slice:
        """Return the nodes that carry unknowns, among all."""
        return slice(1, self.unknown_count + 1)

    @property
    def nodes(self) -> np.ndarray:
        """The nodes that carry unknowns, shape (n,)."""
        return self.all_nodes[self.inner_slice]

    @property
    def uses_even_odd_parts(self) -> bool:
        """Return whether kernels act on even and odd parts over the whole axis."""
        return not self.folded

    @cached_property
    def derivative_matrix(self) -> np.ndarray:
        """First derivative on all nodes, ends included, shape (full_point_count + 2,) squared.

        Entries from Trefethen, Spectral Methods in MATLAB (2000), ch. 6; node differences by a
        trigonometric identity and the diagonal by row sums, against cancellation.
        """
        order = self.full_point_count + 1
        index = np.arange(order + 1)
        ends = np.where((index == 0) | (index == order), 2.0, 1.0) * (-1.0) ** index
        angle = np.pi / (2 * order)
        difference = np.sin(angle * np.add.outer(index, index)) * np.sin(
            angle * np.subtract.outer(index, index)
        )
        np.fill_diagonal(difference, 1.0)
        return _with_zero_row_sums(np.divide.outer(ends, ends) / difference)

    @cached_property
    def inverse_radius(self) -> np.ndarray:
        """1/r on all nodes of a radius (the divergence of radial flow), 0 on other axes."""
        return np.zeros(self.full_point_count + 2)

    @property
    def divergence_matrix(self) -> np.ndarray:
        """Divergence on all nodes of a flow along the axis."""
        return self.derivative_matrix + np.diag(self.inverse_radius)

    @cached_property
    def second_derivative(self) -> np.ndarray:
        """Divergence of the slope of a function that is zero at both ends, shape (n, n).

        Off the diagonal D2_ij = 2 D_ij (D_ii − 1/(x_i − x_j)) (Welfert 1997), diagonal by row sums.
        """
        first = self.derivative_matrix
        distance = np.subtract.outer(self.all_nodes, self.all_nodes)
        np.fill_diagonal(distance, 1.0)
        matrix = 2 * first * (np.diag(first)[:, None] - 1 / distance)
        spread = self.inverse_radius[:, None] * first
        return self.fold_matrix((_with_zero_row_sums(matrix) + spread)[1:-1, 1:-1])

    @cached_property
    def quadrature_weights(self) -> np.ndarray:
        """Clenshaw–Curtis weights of the integral over [0, 1], shape (n,); the ends carry zeros."""
        order = self.full_point_count + 1
        angle = np.pi * np.arange(1, order) / order
        sums = np.ones(order - 1)
        for harmonic in range(1, (order - 1) // 2 + 1):
            sums -= 2 * np.cos(2 * harmonic * angle) / (4 * harmonic**2 - 1)
        if order % 2 == 0:
            sums -= np.cos(order * angle) / (order**2 - 1)
        weights = sums / order
        return 2 * weights[: self.unknown_count] if self.folded else weights

    @cached_property
    def eigenmodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Eigenvalues (n,), eigenvectors as columns (n, n) and their inverse (n, n) of D2.

        The eigenvalues are real, negative and distinct (Gottlieb and Lustman 1983). Each vector
        has unit mean square, so that coefficients measure like the function they stand for.
        """
        values, vectors = np.linalg.eig(self.second_derivative)
        order = np.argsort(-values.real)
        values, vectors = values.real[order], vectors.real[:, order]
        vectors = vectors / np.sqrt(self.quadrature_weights @ vectors**2)
        return values, vectors, np.linalg.inv(vectors)

    @cached_property
    def second_derivative_parts(self) -> np.ndarray:
        """D2; of an axis that is not folded as it acts on even and odd functions' first halves.

        Shape (n, n), or (2, n/2, n/2): halved, for sum and difference of a function's values
        at a node and at its mirror image stand for twice its even and odd part.
        """
        return self.even_odd_parts(self.second_derivative)

    def even_odd_parts(self, matrix: np.ndarray) -> np.ndarray:
        """Split a matrix that commutes or anticommutes with mirroring into even and odd parts."""
        return matrix if self.folded else even_and_odd_matrices(matrix) / 2

    @cached_property
    def even_odd_modes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """``modes`` likewise: eigenvalues (n,), even and odd vectors, and their inverse.

        An even mode has its place as far from the first as an odd one from the last.
        """
        if self.folded:
            return self.eigenmodes
        values, vectors = np.linalg.eig(even_and_odd_matrices(self.second_derivative))
        order = np.argsort(-values.real, axis=-1)
        values = np.take_along_axis(values.real, order, axis=-1)
        vectors = np.take_along_axis(vectors.real, order[:, None], axis=-1)
        half = self.unknown_count // 2
        vectors /= np.sqrt(2 * self.quadrature_weights[:half] @ vectors**2)[:, None]
        return np.append(values[0], values[1, ::-1]), vectors, np.linalg.inv(vectors) / 2

    def cosine_moment_matrix(self, count: int) -> np.ndarray:
        """Rows that integrate a function times cos 2πkx over [0, 1], k < count: (count, n)."""
        return np.cos(2 * np.pi * np.outer(np.arange(count), self.nodes)) * self.quadrature_weights

    @property
    def end_extrapolation_weights(self) -> np.ndarray:
        """Extrapolation weights: the value at an end from those on the four nodes beside it.

        A polynomial through all nodes would grow beyond bounds.
        """
        near = self.all_nodes[1:5]
        others = [np.delete(near, at) for at in range(len(near))]
        return np.array([np.prod(o / (o - node)) for node, o in zip(near, others, strict=True)])

    def matrix_at(self, points: np.ndarray) -> np.ndarray:
        """Matrix from the unknowns to some places (m,), shape (m, n)."""
        return self.fold_matrix(self.matrix_to_points(points)[:, 1:-1], rows=len(points))

    def matrix_to_points(self, points: np.ndarray) -> np.ndarray:
        """Matrix from values on all nodes, ends included, to some places (m,), shape (m, nodes).

        Barycentric formula for Chebyshev–Lobatto nodes (Berrut and Trefethen 2004).
        """
        weights = (-1.0) ** np.arange(self.full_point_count + 2)
        weights[[0, -1]] /= 2
        return _interpolation_matrix(self.all_nodes, weights, points)

    def fold_matrix(
        self, matrix: np.ndarray, *, odd: bool = False, rows: int | None = None
    ) -> np.ndarray:
        """Return a matrix for the first half of the points, by the symmetry of the function."""
        if not self.folded:
            return matrix
        n = self.unknown_count
        half = matrix[: rows or n]
        return np.asarray(half[:, :n] + (-1 if odd else 1) * half[:, : n - 1 : -1])


@dataclass(frozen=True)
class RadialAxis(Axis):
    """The diameter of a disc, for functions of the radius r = |x − 1/2| alone: they are even.

    A folded axis has no node at the centre, so that r is never zero.
    """

    folded: bool = True

    @cached_property
    def inverse_radius(self) -> np.ndarray:
        return 1 / (self.all_nodes - 0.5)

    @cached_property
    def quadrature_weights(self) -> np.ndarray:
        """Weights of the mean over the disc, shape (n,); the ends carry zeros.

        Exact for the polynomials of even degree through all nodes: the mean of T_2k(2r) is
        1/(1 − k²) for even k, else 0.
        """
        order = self.full_point_count + 1
        half = np.arange(0, self.unknown_count + 1, 2)
        means = 1 / (1.0 - half**2)
        means[0] /= 2
        angles = 2 * np.pi * np.outer(half, np.arange(1, self.unknown_count + 1)) / order
        return np.asarray(4 / order * means @ np.cos(angles))


@dataclass(frozen=True)
class TimeAxis:
    """Equidistant collocation in time T over one period 2π, an even number of points.

    The real orthonormal Fourier basis with n = points / 2 is ordered 1, cos T, …, cos (n−1)T,
    cos nT, sin T, …, sin (n−1)T: a harmonic's sine lies n places behind its cosine.
    """

    instant_count: int

    @property
    def nodes(self) -> np.ndarray:
        return 2 * np.pi * np.arange(self.instant_count) / self.instant_count

    @cached_property
    def harmonic_orders(self) -> np.ndarray:
        """Harmonic of each basis function, shape (points,); cos nT has no derivative here."""
        half = self.instant_count // 2
        return np.concatenate([np.arange(half), [half], np.arange(1, half)])

    def _fourier_basis(self, instants: np.ndarray) -> np.ndarray:
        """The basis functions at some instants, shape (points, instants)."""
        angle = np.outer(self.harmonic_orders, instants)
        is_sine = np.arange(self.instant_count)[:, None] > self.instant_count // 2
        basis = np.where(is_sine, np.sin(angle), np.cos(angle)) * np.sqrt(2 / self.instant_count)
        basis[[0, self.instant_count // 2]] /= np.sqrt(2)
        return basis

    @cached_property
    def fourier_matrix(self) -> np.ndarray:
        """Orthonormal rows: coefficients = fourier @ values, shape (points, points)."""
        return self._fourier_basis(self.nodes)

    @cached_property
    def derivative_matrix(self) -> np.ndarray:
        """d/dT on the nodes, shape (points, points)."""
        half = self.instant_count // 2
        rates = np.zeros((self.instant_count, self.instant_count))
        for cosine in range(1, half):
            rates[cosine, half + cosine] = cosine
            rates[half + cosine, cosine] = -cosine
        return self.fourier_matrix.T @ rates @ self.fourier_matrix

    def low_pass_matrix(self, most: float) -> np.ndarray:
        """Return the projection on the harmonics up to about ``most``, shape (points, points)."""
        kept = np.exp(-((self.harmonic_orders / most) ** HARMONICS_CUTOFF_STEEPNESS))
        return np.asarray(self.fourier_matrix.T * kept @ self.fourier_matrix)

    def matrix_at(self, instants: np.ndarray) -> np.ndarray:
        """Matrix from values on the nodes to any instants T (m,), shape (m, points)."""
        return np.asarray(self._fourier_basis(instants).T @ self.fourier_matrix)


def _interpolation_matrix(nodes: np.ndarray, weights: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Matrix from values on nodes to places by their barycentric weights, (places, nodes)."""
    distance = np.subtract.outer(points, nodes)
    hit = distance == 0
    matrix = weights / np.where(hit, 1.0, distance)
    matrix[hit.any(axis=1)] = 0.0
    matrix[hit] = 1.0
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


def _with_zero_row_sums(matrix: np.ndarray) -> np.ndarray:
    """Return a derivative with the diagonal by which it is zero for a constant."""
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


def even_and_odd_matrices(matrix: np.ndarray) -> np.ndarray:
    """Return matrices for even and for odd functions on half of n nodes: (2, …, n/2, n/2).

    It commutes with mirroring, as a second derivative does, or changes its sign, as a first one.
    """
    half = matrix.shape[-1] // 2
    near, far = matrix[..., :half, :half], matrix[..., :half, : half - 1 : -1]
    return np.stack([near + far, near - far])


# The axis with so many unknowns and the period with so many nodes: matrices are computed once.
cached_axis, cached_time_axis = lru_cache(maxsize=64)(Axis), lru_cache(maxsize=64)(TimeAxis)
cached_radial_axis = lru_cache(maxsize=64)(RadialAxis)


@dataclass(frozen=True)
class AngleAxis:
    """Fourier collocation on [start, start + 2π), between the mirror axes, with what mirrors do.

    An axis that is folded by one or both symmetries holds the nodes of a half or a quarter.

    Attributes:
        unknown_count: number of unknowns along the axis, n.
        mirrored_lengthwise: functions are even in ν.
        mirrored_crosswise: functions are the same at ν and π − ν.
    """

    unknown_count: int
    mirrored_lengthwise: bool
    mirrored_crosswise: bool

    # Whether kernels act on the even and the odd part of what is on all of the axis (spectral.py).
    uses_even_odd_parts = False

    @property
    def folded(self) -> bool:
        return self.mirrored_lengthwise or self.mirrored_crosswise

    @property
    def full_point_count(self) -> int:
        """Nodes all around."""
        return self.unknown_count * 2**self.mirrored_lengthwise * 2**self.mirrored_crosswise

    @cached_property
    def all_nodes(self) -> np.ndarray:
        """Nodes all around, those that carry unknowns first, shape (full_point_count,)."""
        # A half that is the same at ν and π − ν lies about 0.
        start = -np.pi / 2 if self.mirrored_crosswise and not self.mirrored_lengthwise else 0.0
        return start + 2 * np.pi * (np.arange(self.full_point_count) + 0.5) / self.full_point_count

    @property
    def nodes(self) -> np.ndarray:
        """The nodes that carry unknowns, shape (n,)."""
        return self.all_nodes[: self.unknown_count]

    @property
    def inner_slice(self) -> slice:
        """Return the nodes that carry unknowns, among all."""
        return slice(0, self.unknown_count)

    @property
    def derivative_matrix(self) -> np.ndarray:
        """First derivative on all nodes, shape (full_point_count, full_point_count)."""
        return self._full_period.derivative_matrix

    @property
    def divergence_matrix(self) -> np.ndarray:
        """Divergence on all nodes of a flow along the axis."""
        return self.derivative_matrix

    @cached_property
    def second_derivative_parts(self) -> np.ndarray:
        """Second derivative of a function of the axis' symmetries, shape (n, n)."""
        fourier, harmonics = self._full_period.fourier_matrix, self._full_period.harmonic_orders
        return self._folded_matrix(-(fourier[:, : self.unknown_count].T * harmonics**2) @ fourier)

    @cached_property
    def quadrature_weights(self) -> np.ndarray:
        """Return the weights of the mean over ν, shape (n,)."""
        return np.full(self.unknown_count, 1 / self.unknown_count)

    @cached_property
    def eigenmodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Eigenvalues (n,), eigenvectors as columns of unit mean square and their inverse."""
        values, vectors = np.linalg.eigh(self.second_derivative_parts)
        size = np.sqrt(self.unknown_count)
        return values[::-1], vectors[:, ::-1] * size, vectors[:, ::-1].T / size

    @property
    def even_odd_modes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """``modes`` likewise."""
        return self.eigenmodes

    def cosine_moment_matrix(self, count: int) -> np.ndarray:
        """Rows that average a function times cos 2kν, k < count: (count, n)."""
        return np.cos(2 * np.outer(np.arange(count), self.nodes)) * self.quadrature_weights

    def matrix_to_points(self, points: np.ndarray) -> np.ndarray:
        """Matrix from values on all nodes to some places (m,), shape (m, full_point_count)."""
        return self._full_period.matrix_at(points - self.all_nodes[0])

    @cached_property
    def _mirror_index_and_sign(self) -> tuple[np.ndarray, np.ndarray]:
        """Return each node's unknown, and the sign of an odd function there: (−1)^mirrors."""
        index, sign = np.arange(self.full_point_count), np.ones(self.full_point_count)
        for image in self.mirror_image_indices:
            sign = np.where(index < image[index], sign, -sign)
            index = np.minimum(index, image[index])
        return index, sign

    @property
    def mirror_image_indices(self) -> list[np.ndarray]:
        """Return the images of all nodes by each symmetry."""
        images = -self.all_nodes, np.pi - self.all_nodes
        step = 2 * np.pi / self.full_point_count
        return [
            np.round((image - self.all_nodes[0]) / step).astype(int) % self.full_point_count
            for image, has in zip(
                images, (self.mirrored_lengthwise, self.mirrored_crosswise), strict=True
            )
            if has
        ]

    def matrix_at(self, points: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """Matrix from the unknowns to some places (m,), shape (m, n).

        ``odd`` is for a function that changes its sign at each mirror.
        """
        return self._folded_matrix(self.matrix_to_points(points), odd=odd)

    @property
    def _full_period(self) -> TimeAxis:
        return cached_time_axis(self.full_point_count)

    def _folded_matrix(self, matrix: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """Return a matrix for the unknowns alone, by the symmetry of the function it acts on."""
        folded = np.zeros((len(matrix), self.unknown_count))
        for at, sign, column in zip(*self._mirror_index_and_sign, matrix.T, strict=True):
            folded[:, at] += sign * column if odd else column
        return folded

    def derivative_at_unknowns(self, *, odd: bool) -> np.ndarray:
        """First derivative at the unknowns of a function that mirrors keep, or change in sign."""
        return self._folded_matrix(self.derivative_matrix[: self.unknown_count], odd=odd)


cached_angle_axis = lru_cache(maxsize=64)(AngleAxis)


@dataclass(frozen=True)
class FluxPoints:
    """Chebyshev–Gauss points of an axis, as many as it has unknowns, n.

    The pressure is known on the axis' own nodes and vanishes, as an excess, at the ends; the
    velocity along the axis is free there, so that no point of it lies at an end. About the middle
    of a folded axis the velocity along it is odd, all else even. All matrices have the shape
    (n, n) and lengths are those of the axis.
    """

    axis: Axis

    @cached_property
    def all_points(self) -> np.ndarray:
        """Shape (full_point_count,), on (0, 1)."""
        count = self.axis.full_point_count
        return (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2

    @property
    def matrix_from_all_nodes(self) -> np.ndarray:
        """Values here of a function that is known on all nodes, shape (n, nodes)."""
        return self.axis.matrix_to_points(self.all_points)[: self.axis.unknown_count]

    def matrices(self, length: float) -> dict[str, np.ndarray]:
        """Return the matrices of an axis of some length for kernels, by name.

        Of a function on the nodes that vanishes at the ends: its values here, ``values``, and its
        ``slope``. Of the velocity along the axis: ``along``, its derivative here; ``nodes`` and
        ``divergence``, its values and divergence on the nodes.

        Of a velocity along the other axis: ``across``, its derivative along this one on the nodes,
        as if it vanished at the ends as it does where the gas comes in; ``edge``, what that lacks
        per velocity at each end, of a folded axis, whose ends are alike, their sum first;
        ``end_extrapolation_weights`` as of the axis.
        """
        axis, parts = self.axis, self.axis.even_odd_parts
        to_points, to_nodes = axis.matrix_to_points(self.all_points), self.matrix_to_nodes
        first, last = axis.derivative_matrix[1 : axis.unknown_count + 1, [0, -1]].T
        edge = np.stack([first + last, 0 * last] if axis.folded else [first, last])
        slope = (to_points @ axis.derivative_matrix)[:, 1:-1]
        spread = axis.inverse_radius[1:-1, None] * to_nodes
        return {
            "values": parts(axis.fold_matrix(to_points[:, 1:-1])),
            "nodes": parts(self.matrix_to_inner_nodes),
            "slope": parts(axis.fold_matrix(slope)) / length,
            "along": parts(axis.fold_matrix(self._derivative, odd=True)) / length,
            "divergence": parts(axis.fold_matrix(to_nodes @ self._derivative + spread, odd=True))
            / length,
            "across": parts(axis.fold_matrix(axis.derivative_matrix[1:-1, 1:-1])) / length,
            "edge": edge / length,
            "to_end": axis.end_extrapolation_weights,
        }

    @property
    def matrix_to_nodes(self) -> np.ndarray:
        """Interpolation from all points to all nodes inside, (full_point_count,
        full_point_count)."""
        return self.matrix_at(self.axis.all_nodes[1:-1])

    @property
    def matrix_to_inner_nodes(self) -> np.ndarray:
        """The velocity along the axis at the nodes that carry unknowns, shape (n, n)."""
        return self.axis.fold_matrix(self.matrix_to_nodes, odd=True)

    def matrix_to_finer_points(self, finer: FluxPoints) -> np.ndarray:
        """The velocity along the axis on another one's points, shape (finer n, n)."""
        return self.axis.fold_matrix(
            self.matrix_at(finer.all_points), odd=True, rows=finer.axis.unknown_count
        )

    @cached_property
    def _barycentric_weights(self) -> np.ndarray:
        """Barycentric weights of the points (Berrut and Trefethen 2004)."""
        index = np.arange(self.axis.full_point_count)
        return (-1.0) ** index * np.sin(np.pi * (index + 0.5) / len(index))

    def matrix_at(self, points: np.ndarray) -> np.ndarray:
        """Interpolation from all points to places of the axis, (places, full_point_count)."""
        return _interpolation_matrix(self.all_points, self._barycentric_weights, points)

    @cached_property
    def _derivative(self) -> np.ndarray:
        """Derivative on all points."""
        distance = np.subtract.outer(self.all_points, self.all_points)
        np.fill_diagonal(distance, 1.0)
        inverse = 1 / self._barycentric_weights
        return _with_zero_row_sums(np.divide.outer(inverse, inverse) / distance)


@dataclass(frozen=True)
class AngleFluxPoints:
    """The same of an outline's ν, which has no ends: its nodes, on which a velocity along it is odd
    at each mirror.
    """

    axis: AngleAxis

    @property
    def matrix_from_all_nodes(self) -> np.ndarray:
        return np.eye(self.axis.full_point_count)[self.axis.inner_slice]

    def matrices(self, length: float) -> dict[str, np.ndarray]:
        same, n = np.eye(self.axis.unknown_count), self.axis.unknown_count
        even, odd = (self.axis.derivative_at_unknowns(odd=odd) / length for odd in (False, True))
        ends = {"edge": np.zeros((2, n)), "to_end": np.zeros(4)}
        values = {"values": same, "nodes": same}
        return {**values, **ends, "slope": even, "across": even, "along": odd, "divergence": odd}

    @property
    def matrix_to_inner_nodes(self) -> np.ndarray:
        return np.eye(self.axis.unknown_count)

    def matrix_to_finer_points(self, finer: AngleFluxPoints) -> np.ndarray:
        return self.axis.matrix_at(finer.axis.nodes, odd=True)


@lru_cache(maxsize=64)
def flux_points(of: Axis | AngleAxis) -> FluxPoints | AngleFluxPoints:
    """Flux points of an axis; their matrices are computed once."""
    return FluxPoints(of) if isinstance(of, Axis) else AngleFluxPoints(of)

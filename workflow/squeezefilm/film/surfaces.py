"""The surface that vibrates, a disc or a rectangle: its edge, nets of points, smooth modes.

All that differs between the two is here. Coordinates are from the surface's centre; scaled ones
are 1 at its edge: on a disc over its radius, on a rectangle each over half its side.
"""

from dataclasses import dataclass, field
from math import ceil, cos, floor, pi, radians, sin
from typing import ClassVar, Literal

import numpy as np
from numpy.polynomial.legendre import legvander

from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS
from squeezefilm.sections import SECTION_CONFIG, Length

# Points of the nets on which a profile is looked at all over: along a radius, around; a side.
NET_RADIUS_COUNT, NET_ANGLE_COUNT, NET_SIDE_COUNT = 41, 72, 53
# Phase at a rectangle's edge of the coordinate sin(phase · x)/sin(phase) of its modes, in rad.
# Polynomials of x itself need over twice the points of a scan, which lie evenly: between its last
# points they magnify the noise (Kosloff and Tal-Ezer, J. Comput. Phys. 104, 1993).
EDGE_PHASE_RAD = pi / 3
# Waves per metre along a rectangle's shorter side over those along the longer, of the families of
# its modes: a plate's waves often go along one side.
MODE_FAMILY_WAVE_RATIOS = (1.0, 0.25, 2.0, 4.0)

# Two numbers of each smooth mode, by rising degree.
ModeOrders = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Disc:
    """A disc; pads lie on it by their polar position, modes are Zernike's."""

    radius_m: float
    position_columns = POLAR_COLUMNS
    config_key = "actuator.surface_radius"
    line_scan_problem = (
        "points on a line need an axisymmetric shape: say actuator.profile.axisymmetric: true"
    )
    whole_of_part = (
        "write the mirrored points too, or say actuator.profile.axisymmetric: true if the shape "
        "depends on the radius only"
    )
    wave_ratios = (1.0,)

    @property
    def half_extents_m(self) -> tuple[float, float]:
        """Half of what it is across along x and along y."""
        return self.radius_m, self.radius_m

    @property
    def text(self) -> str:
        """Return the surface's shape with its size."""
        return f"disc of radius {self.radius_m * 1e3:.4g} mm"

    def enclosing_text(self, x_m: np.ndarray, y_m: np.ndarray) -> str:
        """The key and the size with which points lie on a surface of this shape."""
        return f"{self.config_key}: {_rounded_up_mm(np.hypot(x_m, y_m).max())}"

    def relative_distance(self, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Relative distance of points from the centre: 0 at the centre, 1 on the edge."""
        return np.asarray(np.hypot(x_m, y_m) / self.radius_m)

    def extent_along_m(self, direction_deg: float) -> float:
        """Farthest distance from the centre along a direction, in metres."""
        return self.radius_m

    def position_text(self, x_m: float, y_m: float) -> str:
        """A place in words."""
        return f"{np.hypot(x_m, y_m) * 1e3:.5g} mm from the centre"

    def pad_extent_text(self, outline_m: np.ndarray) -> str:
        """Extent of a pad by points of its edge from its centre, shape (n, 2), in words."""
        return f"it reaches {np.hypot(*outline_m.T).max() * 1e3:.4g} mm from its centre"

    def allowed_positions_text(self, outline_m: np.ndarray, x_m: float, y_m: float) -> str:
        """The limit of a pad's position in the direction of one, in words.

        outline_m, shape (n, 2), are points of the pad's edge from its centre; with its centre at
        the surface's the pad must lie on the surface.
        """
        along_m = outline_m @ (x_m, y_m) / np.hypot(x_m, y_m)
        room_m = np.sqrt(along_m**2 + self.radius_m**2 - np.sum(outline_m**2, axis=1)) - along_m
        return (
            f"in this direction its centre may lie at most {_mm_rounded_down(room_m.min())} mm out"
        )

    def net_points_and_weights(
        self, *, finer: bool = False
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x_m, y_m of points all over, edge included, and weights in proportion to areas."""
        radii, angles = (101, 192) if finer else (NET_RADIUS_COUNT, NET_ANGLE_COUNT)
        r_m = np.linspace(0, self.radius_m, radii)
        r_m, phi = np.meshgrid(r_m, 2 * pi * np.arange(angles) / angles, indexing="ij")
        return r_m * np.cos(phi), r_m * np.sin(phi), r_m

    def orders_up_to(
        self, degree: int, *, degrees_more: int = 0, coordinate: str = "", wave_ratio: float = 1.0
    ) -> ModeOrders:
        """Zernike's modes (n, m) of degree n ≤ ``degree`` and so many more.

        With m = 0 alone if they depend on the ``coordinate`` r alone. n ≥ |m| and n − |m| is even.
        They span all polynomials in x, y of the degree.
        """
        return tuple(
            (n, m)
            for n in range(degree + degrees_more + 1)
            for m in range(-n, n + 1, 2)
            if m == 0 or coordinate != "r"
        )

    def modes_at(self, orders: ModeOrders, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Values of Zernike's modes at points, shape (*x_m.shape, modes).

        R_n^|m|(ρ) cos mφ for m ≥ 0 and R_n^|m|(ρ) sin |m|φ for m < 0 (Born and Wolf, 9.2), with
        R_n^m(ρ) = (−1)^k ρ^m P_k^(m,0)(1 − 2ρ²), k = (n − m)/2 and Jacobi's P.
        """
        from scipy.special import eval_jacobi

        x, y = x_m / self.radius_m, y_m / self.radius_m
        square, turned = x**2 + y**2, x + 1j * y
        powers = {m: turned**m for m in {abs(m) for _, m in orders}}  # ρ^m (cos mφ + i sin mφ)
        radial = {
            (k, m): (-1) ** k * eval_jacobi(k, m, 0, 1 - 2 * square)
            for k, m in {((n - abs(m)) // 2, abs(m)) for n, m in orders}
        }
        values = np.empty((*x.shape, len(orders)))
        for index, (n, m) in enumerate(orders):
            angular = powers[abs(m)].imag if m < 0 else powers[abs(m)].real
            values[..., index] = radial[(n - abs(m)) // 2, abs(m)] * angular
        return values

    def sum_of_modes_at(
        self, orders: ModeOrders, coefficients: np.ndarray, x_m: np.ndarray, y_m: np.ndarray
    ) -> np.ndarray:
        """Return ``modes_at`` times their coefficients."""
        return self.modes_at(orders, x_m, y_m) @ coefficients


@dataclass(frozen=True)
class Rectangle:
    """A rectangular surface, instead of `surface_radius`; the pad must lie on it.

    Pads lie on it by x and y, modes are Legendre's products in stretched coordinates.

    Attributes:
        shape: its outline; a disc has `actuator.surface_radius` in place of `actuator.surface`
        length_x_m: its side along x
        length_y_m: its side along y
    """

    __pydantic_config__ = SECTION_CONFIG

    shape: Literal["rectangle"] = field(default="rectangle", kw_only=True)
    length_x_m: Length
    length_y_m: Length
    position_columns: ClassVar = CARTESIAN_COLUMNS
    config_key: ClassVar = "actuator.surface"
    line_scan_problem: ClassVar = (
        "points on a line do not determine the shape across it: scan more lines, or, if it is the "
        "same all across, say actuator.profile.along: x (or y, as the line runs)"
    )
    whole_of_part: ClassVar = "write the mirrored points too"
    wave_ratios: ClassVar = MODE_FAMILY_WAVE_RATIOS

    @property
    def half_extents_m(self) -> tuple[float, float]:
        return self.length_x_m / 2, self.length_y_m / 2

    @property
    def text(self) -> str:
        return f"{self.length_x_m * 1e3:.4g} × {self.length_y_m * 1e3:.4g} mm rectangle"

    def enclosing_text(self, x_m: np.ndarray, y_m: np.ndarray) -> str:
        """As of a disc."""
        sides = [
            f"length_{axis}: {_rounded_up_mm(max(side_m, 2 * np.abs(at_m).max()))}"
            for axis, side_m, at_m in zip(
                "xy", (self.length_x_m, self.length_y_m), (x_m, y_m), strict=True
            )
        ]
        return f"{self.config_key}: {{shape: rectangle, {', '.join(sides)}}}"

    def relative_distance(self, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        half_x, half_y = self.half_extents_m
        return np.maximum(np.abs(x_m) / half_x, np.abs(y_m) / half_y)

    def extent_along_m(self, direction_deg: float) -> float:
        c, s = cos(radians(direction_deg)), sin(radians(direction_deg))
        return (abs(c) * self.length_x_m + abs(s) * self.length_y_m) / 2

    def position_text(self, x_m: float, y_m: float) -> str:
        return f"at x = {x_m * 1e3:z.5g} mm, y = {y_m * 1e3:z.5g} mm"

    def pad_extent_text(self, outline_m: np.ndarray) -> str:
        x_mm, y_mm = np.ptp(outline_m, axis=0) * 1e3
        return f"it is {x_mm:.4g} × {y_mm:.4g} mm along x and y"

    def allowed_positions_text(self, outline_m: np.ndarray, x_m: float, y_m: float) -> str:
        x, y = map(_mm_rounded_down, self.half_extents_m - np.abs(outline_m).max(axis=0))
        return f"its centre must lie within x = ±{x} mm, y = ±{y} mm"

    def net_points_and_weights(
        self, *, finer: bool = False
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        side = np.linspace(-1, 1, 141 if finer else NET_SIDE_COUNT)
        cell_fraction = np.where(np.abs(side) < 1, 1.0, 0.5)
        x, y = np.meshgrid(side, side, indexing="ij")
        return (
            x * self.half_extents_m[0],
            y * self.half_extents_m[1],
            np.outer(cell_fraction, cell_fraction),
        )

    def orders_up_to(
        self, degree: int, *, degrees_more: int = 0, coordinate: str = "", wave_ratio: float = 1.0
    ) -> ModeOrders:
        """Modes (i, j) within the ellipse of ``degree`` along one side and no more along the other.

        ``wave_ratio`` is that of the waves per metre (MODE_FAMILY_WAVE_RATIOS). Both half axes are
        longer by ``degrees_more``. Of a ``coordinate`` alone, x or y, the other's order is 0.
        """
        sides = np.array([self.length_x_m, self.length_y_m])
        sides[np.argmin(sides)] *= wave_ratio
        half_axes = np.maximum(degree * sides / sides.max() + degrees_more, 1e-9)
        if coordinate:
            half_axes["yx".index(coordinate)] = 1e-9
        every = [
            divmod(n, degree + degrees_more + 1) for n in range((degree + degrees_more + 1) ** 2)
        ]
        # Rounded, so that those of a degree come first among those of the next.
        sizes = np.hypot(*(np.array(every) / half_axes).T).round(9)
        order = np.argsort(sizes, kind="stable")
        return tuple(every[n] for n in order[: np.sum(sizes <= 1)])

    def modes_at(self, orders: ModeOrders, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Values of P_i(ξ) P_j(η), shape (*x_m.shape, modes).

        P are Legendre's; ξ = sin(βx)/sin β and η alike, x over half the side and β EDGE_PHASE_RAD.
        """
        along_x, along_y = np.array(orders).T
        polynomials_x, polynomials_y = self._polynomials_at(orders, x_m, y_m)
        values: np.ndarray = polynomials_x[..., along_x] * polynomials_y[..., along_y]
        return values.reshape(*np.shape(x_m), len(orders))

    def sum_of_modes_at(
        self, orders: ModeOrders, coefficients: np.ndarray, x_m: np.ndarray, y_m: np.ndarray
    ) -> np.ndarray:
        """Return ``modes_at`` times their coefficients, by sums along x of each degree along y."""
        along_x, along_y = np.array(orders).T
        matrix = np.zeros((along_x.max() + 1, along_y.max() + 1), dtype=coefficients.dtype)
        matrix[along_x, along_y] = coefficients
        polynomials_x, polynomials_y = self._polynomials_at(orders, x_m, y_m)
        return np.asarray(np.einsum("...j,...j->...", polynomials_x @ matrix, polynomials_y))

    def _polynomials_at(
        self, orders: ModeOrders, x_m: np.ndarray, y_m: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Values of all P_i(ξ) and P_j(η) up to the modes' degrees, (*x_m.shape, degrees)."""
        most_x, most_y = np.max(orders, axis=0).tolist()
        x, y = (
            np.sin(EDGE_PHASE_RAD * at_m / half_m) / sin(EDGE_PHASE_RAD)
            for at_m, half_m in zip((x_m, y_m), self.half_extents_m, strict=True)
        )
        return legvander(x, most_x), legvander(y, most_y)


def _rounded_up_mm(length_m: float) -> str:
    """A length in words, no shorter than it is."""
    return f"{ceil(length_m * 1e7 - 1e-6) / 1e4:.10g} mm"


Surface = Disc | Rectangle


def _mm_rounded_down(length_m: float) -> str:
    """A length that is allowed, in millimetres."""
    return f"{floor(length_m * 1e5 * (1 + 1e-12)) / 100:g}"

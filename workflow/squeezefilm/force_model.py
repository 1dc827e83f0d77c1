"""The empirical force models: a closed formula for the mean force, fitted to simulations.

Both models are the piston formula with free coefficients. With eps = hv/h0,

    eta = sqrt(1 + theta0 eps^2) / sqrt(1 - theta1 q eps^2) + theta2

where q = 1 for the centred finger (paper eq. 7) and
q = 1 + theta3 phi/45 + theta4 phi_r for a finger moved over the surface (eq. 14).
Angles are in degrees and radii in metres, so theta4 has the unit 1/m; eta is in newtons.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError

Array = NDArray[np.float64]

ANGLE_UNIT_DEG = 45.0
"""The angle that model (14) scales phi by: the half-sector that symmetry leaves."""


@dataclass(frozen=True)
class Factors:
    """The factors of n experiments, each an array of shape (n,).

    h0_m: mean gap; hv_m: vibration amplitude at the centre; phi_r_m, phi_deg: polar position
    of the finger's centre (both zero where the finger is centred).
    """

    h0_m: Array
    hv_m: Array
    phi_r_m: Array
    phi_deg: Array

    @classmethod
    def of(
        cls,
        *,
        h0_m: ArrayLike,
        hv_m: ArrayLike,
        phi_r_m: ArrayLike = 0.0,
        phi_deg: ArrayLike = 0.0,
    ) -> Factors:
        """Factors from numbers or sequences, brought to one length.

        Raises InputError where a value is not finite, a gap is not positive or the lengths differ.
        """
        given = {"h0_m": h0_m, "hv_m": hv_m, "phi_r_m": phi_r_m, "phi_deg": phi_deg}
        columns = {name: np.atleast_1d(np.asarray(v, dtype=float)) for name, v in given.items()}
        for name, column in columns.items():
            if not np.all(np.isfinite(column)):
                raise InputError(f"{name}: a factor is not a finite number; all must be")
        if np.any(columns["h0_m"] <= 0):
            raise InputError("h0_m: a gap is zero or negative; gaps must be positive")
        try:
            h0, hv, radius, angle = np.broadcast_arrays(*columns.values())
        except ValueError:
            lengths = ", ".join(f"{name} {column.size}" for name, column in columns.items())
            raise InputError(f"factors of different lengths ({lengths}); give one length") from None
        return cls(h0, hv, radius, angle)

    @property
    def epsilon(self) -> Array:
        """Excursion ratio hv/h0, shape (n,)."""
        return self.hv_m / self.h0_m

    def __len__(self) -> int:
        return len(self.h0_m)


@dataclass(frozen=True)
class ForceModel:
    """One empirical model: its names, its value and its gradient.

    factor_names lists the factors the model depends on, in the order of a design's columns.
    """

    name: str
    parameter_names: tuple[str, ...]
    factor_names: tuple[str, ...]

    def factors(self, points: ArrayLike) -> Factors:
        """Factors from the rows of a design, shape (n, number of factors), in SI units."""
        points = np.asarray(points, dtype=float)
        if points.ndim != 2 or points.shape[1] != len(self.factor_names):
            raise InputError(
                f"a design for the {self.name} model has the columns "
                f"{', '.join(self.factor_names)}; got an array of shape {points.shape}"
            )
        return Factors.of(**dict(zip(self.factor_names, points.T, strict=True)))

    def evaluate(self, theta: ArrayLike, factors: Factors) -> Array:
        """Force eta in newtons (paper eq. 7 or 14).

        theta has shape (p,) or, for a whole population, (m, p); the result has shape (n,) or
        (m, n). Where a root is undefined the result is NaN.
        """
        full = self._full(theta)
        numerator, denominator = _radicands(full, factors)
        root = np.sqrt(np.where(numerator >= 0, numerator, np.nan))
        root /= np.sqrt(np.where(denominator > 0, denominator, np.nan))
        return root + full[..., 2, None]

    def gradient(self, theta: ArrayLike, factors: Factors) -> Array:
        """Derivatives of eta with respect to theta, shape (n, p): eqs (8)-(10) or (15)-(19).

        theta has shape (p,). Where a root is undefined the row is NaN.
        """
        full = self._full(theta)
        if full.ndim != 1:
            raise InputError(f"gradient takes one theta, not a population of {len(full)}")
        numerator, denominator = _radicands(full, factors)
        defined = (numerator > 0) & (denominator > 0)
        a = np.sqrt(np.where(defined, numerator, np.nan))
        b = np.sqrt(np.where(defined, denominator, np.nan))
        square = factors.epsilon**2
        by_coefficient = square * a / (2 * b**3)  # of eps^2 under the lower root
        angle = factors.phi_deg / ANGLE_UNIT_DEG
        columns = (
            square / (2 * a * b),
            by_coefficient * _position(full, factors),
            np.where(defined, 1.0, np.nan),
            by_coefficient * full[1] * angle,
            by_coefficient * full[1] * factors.phi_r_m,
        )
        return np.column_stack(columns[: len(self.parameter_names)])

    def amplitude_for_force(
        self,
        theta: ArrayLike,
        *,
        force_n: float,
        h0_m: float,
        phi_r_m: float = 0.0,
        phi_deg: float = 0.0,
    ) -> float:
        """Amplitude hv in metres that gives the wanted force at a gap and position.

        The model solved for eps^2: with g = (force - theta2)^2,
        eps^2 = (g - 1)/(theta0 + g theta1 q). Raises InputError where no amplitude between
        rest and contact (0 <= hv < h0) gives the force.
        """
        full = self._full(theta)
        if full.ndim != 1:
            raise InputError(f"amplitude_for_force takes one theta, not {len(full)} of them")
        if not np.isfinite(force_n):
            raise InputError(f"force_n: {force_n} is not a finite number")
        at_gap = Factors.of(h0_m=h0_m, hv_m=0.0, phi_r_m=phi_r_m, phi_deg=phi_deg)
        g = (force_n - full[2]) ** 2
        slope = full[0] + g * full[1] * _position(full, at_gap)[0]
        square = (g - 1) / slope if slope != 0 else np.nan
        if 0 <= square < 1:
            hv_m = float(np.sqrt(square) * h0_m)
            found = Factors.of(h0_m=h0_m, hv_m=hv_m, phi_r_m=phi_r_m, phi_deg=phi_deg)
            reached = self.evaluate(theta, found)[0]
            # Squaring brings in a false solution, on the other branch of the root.
            if abs(reached - force_n) <= 1e-9 * (1 + abs(force_n)):
                return hv_m
        raise InputError(
            f"force_n: the model gives {force_n:g} N at h0_m = {h0_m:g} m for no amplitude "
            f"below contact (hv_m < h0_m); at rest it gives {1 + full[2]:.3g} N"
        )

    def _full(self, theta: ArrayLike) -> Array:
        """theta checked and filled up with zeros to the five parameters of eq. (14)."""
        theta = np.asarray(theta, dtype=float)
        count = len(self.parameter_names)
        if theta.ndim not in (1, 2) or theta.shape[-1] != count:
            raise InputError(
                f"theta: the {self.name} model has {count} parameters; got shape {theta.shape}"
            )
        return np.concatenate([theta, np.zeros((*theta.shape[:-1], 5 - count))], axis=-1)


def _position(theta: Array, factors: Factors) -> Array:
    """The position's part q of eq. (14); one where theta3 and theta4 are zero."""
    angle = factors.phi_deg / ANGLE_UNIT_DEG
    return 1 + theta[..., 3, None] * angle + theta[..., 4, None] * factors.phi_r_m


def _radicands(theta: Array, factors: Factors) -> tuple[Array, Array]:
    """What stands under the upper and the lower root of eq. (14).

    Parameters of a wide search may overflow here; what is not finite is not defined either.
    """
    square = factors.epsilon**2
    with np.errstate(over="ignore", invalid="ignore"):
        upper = 1 + theta[..., 0, None] * square
        lower = 1 - theta[..., 1, None] * _position(theta, factors) * square
    return upper, lower


TWO_FACTOR = ForceModel(
    name="two_factor",
    parameter_names=("theta0", "theta1", "theta2"),
    factor_names=("h0_m", "hv_m"),
)
FOUR_FACTOR = ForceModel(
    name="four_factor",
    parameter_names=("theta0", "theta1", "theta2", "theta3", "theta4"),
    factor_names=("h0_m", "hv_m", "phi_r_m", "phi_deg"),
)
MODELS = {model.name: model for model in (TWO_FACTOR, FOUR_FACTOR)}


def get_model(name: str) -> ForceModel:
    """The model of that name; raises InputError for an unknown one."""
    if name not in MODELS:
        raise InputError(f"model {name!r} is unknown; known are {', '.join(MODELS)}")
    return MODELS[name]

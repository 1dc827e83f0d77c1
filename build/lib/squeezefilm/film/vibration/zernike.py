"""Zernike's polynomials: smooth functions on a disc, from coarse to fine (Born and Wolf, 9.2).

Mode (n, m), n ≥ |m| with n − |m| even, is R_n^|m|(ρ) times cos mφ for m ≥ 0 and sin |m|φ for m < 0,
on the unit disc. With degrees up to n they span all polynomials in x, y of degree n.
"""

from collections.abc import Sequence

import numpy as np


def orders_up_to(degree: int, *, axisymmetric: bool) -> tuple[tuple[int, int], ...]:
    """The modes (n, m) of degree n ≤ ``degree``; those with m = 0 alone if ``axisymmetric``."""
    return tuple(
        (n, m) for n in range(degree + 1) for m in range(-n, n + 1, 2) if m == 0 or not axisymmetric
    )


def modes_at(orders: Sequence[tuple[int, int]], *, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Values of the modes at points of the unit disc, shape (*x.shape, modes).

    R_n^m(ρ) = (−1)^k ρ^m P_k^(m,0)(1 − 2ρ²) with k = (n − m)/2 and Jacobi's P.
    """
    from scipy.special import eval_jacobi

    square = x**2 + y**2
    turned = x + 1j * y
    powers = {m: turned**m for m in {abs(m) for _, m in orders}}  # ρ^m (cos mφ + i sin mφ)
    values = np.empty((*np.shape(x), len(orders)))
    for index, (n, m) in enumerate(orders):
        k = (n - abs(m)) // 2
        angular = powers[abs(m)].imag if m < 0 else powers[abs(m)].real
        values[..., index] = (-1) ** k * eval_jacobi(k, abs(m), 0, 1 - 2 * square) * angular
    return values

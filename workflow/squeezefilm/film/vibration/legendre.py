"""Products of Legendre's polynomials: smooth functions on a rectangle, from coarse to fine.

Mode (i, j) is P_i(x) P_j(y) on the square [-1, 1]², its degree i + j. With degrees up to n they
span all polynomials in x, y of degree n, as Zernike's do on a disc.
"""

from collections.abc import Sequence

import numpy as np
from numpy.polynomial.legendre import legvander


def orders_up_to(degree: int) -> tuple[tuple[int, int], ...]:
    """The modes (i, j) of degree i + j ≤ ``degree``."""
    return tuple((n - j, j) for n in range(degree + 1) for j in range(n + 1))


def modes_at(orders: Sequence[tuple[int, int]], *, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Values of the modes at points of the square, shape (*x.shape, modes)."""
    along_x, along_y = np.array(orders).T
    values: np.ndarray = (
        legvander(np.ravel(x), int(along_x.max()))[:, along_x]
        * legvander(np.ravel(y), int(along_y.max()))[:, along_y]
    )
    return values.reshape(*np.shape(x), len(orders))

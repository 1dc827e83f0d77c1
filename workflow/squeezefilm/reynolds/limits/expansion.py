"""What an expansion of the mean overpressure in 1/√σ or in ε consists of."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np

from squeezefilm.reynolds.limits.films import Films


@dataclass(frozen=True)
class Expansion:
    """A mean overpressure to order 1/√σ: the mean of ``density`` over the finger and ``layer``.

    ``gross`` is what ``layer`` is made of without cancellation. Shapes (B, nx + 2, ny + 2), (B,)
    and (B,).
    """

    density: np.ndarray
    layer: np.ndarray
    gross: np.ndarray


@dataclass(frozen=True)
class SecondOrder:
    """The mean overpressure over ε² for ε → 0: that of ``flow`` − ``loss``, and ``rim``.

    ``rim``, shape (B,), is what the rim drives by itself.
    """

    flow: np.ndarray
    loss: np.ndarray
    rim: np.ndarray


Part = TypeVar("Part", Expansion, SecondOrder)


def joined(which: np.ndarray, there: Part, elsewhere: Part) -> Part:
    """Parts of a batch put together: ``there`` where the mask ``which``, (B,), says so."""
    values: dict[str, np.ndarray] = {}
    for each in fields(there):
        some: np.ndarray = getattr(there, each.name)
        values[each.name] = np.empty((len(which), *some.shape[1:]))
        values[each.name][which] = some
        values[each.name][~which] = getattr(elsewhere, each.name)
    return type(there)(**values)


def layer_correction(
    films: Films, *, d: np.ndarray, change: np.ndarray, influence: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(∮ d dl + ∫ u weight dA) / (√σ area), u with ``change`` on the rim; net and gross.

    u jumps at corners, so it is never computed. With χ the solution of the adjoint equation with
    the source weight that is zero on the rim, Green's identity turns ∫ u weight dA into
    −∮ u ∂χ/∂n dl, n inward: ``influence`` is −∂χ/∂n. Under a gap G at rest the layer is G times as
    thick, and Green's identity is that of ∇·(G³∇).
    """
    gap = films.rest_on_rim
    thick = gap / np.sqrt(films.sigma / (1 + films.slip))[:, None]
    by_core = gap**3 * influence * change
    net = films.rim_integral(thick * (d + by_core))
    return net, films.rim_integral(thick * (np.abs(d) + np.abs(by_core)))

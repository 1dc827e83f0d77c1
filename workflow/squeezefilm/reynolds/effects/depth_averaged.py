"""Error of the depth-averaged inertia and heat: a parabola stands for each profile across the gap.

An estimate, from second-order theory of small motion for a square piston. ``depth_averaged.csv`` is
its mean force over ε², in p0 times the pad's area, with the depth-averaged terms and resolved
across the gap: isothermal velocity; or, with heat 1, temperature too (Pr 0.71, γ 1.4, κ 0.7; there
the solver's averaged force at ε = 0.005). The error grows as Re² at first and depends little on the
squeeze number. At Re 40 it is 2.9 to 11 %, too far from that at 20 to be interpolated: at small σ
the force has resonances in Re.
"""

from __future__ import annotations

from functools import lru_cache
from math import nan
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import THICK_SIGMA

TABLE = Path(__file__).with_name("depth_averaged.csv")
# Below THICK_SIGMA strips that resolve the profiles were compared up to this Re, and no further.
MOST_REYNOLDS_THICK = 2.0
# By how much the change may be off, as a share of the largest at the same Re, for ε → 0 and for
# each unit of ε: 288 strips that resolve the profiles, piston and sinc, ε 0.02–0.8, σ 0.5–1e4.
OFF, OFF_PER_EPSILON = 0.7, 1.0
OFF_THICK, OFF_THICK_PER_EPSILON = 2.0, 5.0


def error_percent(scene: Scene) -> tuple[float, float]:
    """Return what resolving the profiles changes of a scene's force, and how sure that is.

    Returns:
        The change in per cent of the force, and by how much it may be off: other profiles and
        amplitudes than the table's. 0 where the scene has neither term; NaN beyond the table's Re,
        and beyond Re 2 below its σ. Where no sign is known, the change is 0 and may be off by its
        size: below the table's σ, and for heat without inertia.
    """
    inertia, heat = (getattr(scene.gas, name) == "included" for name in ("inertia", "heat"))
    reynolds, sigma = scene.modified_reynolds, scene.sigma
    if not (inertia or heat):
        return 0.0, 0.0
    thick = sigma < THICK_SIGMA
    nodes, errors = _errors(heat)
    if reynolds > (MOST_REYNOLDS_THICK if thick else errors.x[-1]):
        return nan, nan
    along = reynolds**2 * errors(max(reynolds, errors.x[0]))
    largest = float(np.abs(along).max())
    if thick or not inertia:
        return 0.0, largest * (OFF_THICK + OFF_THICK_PER_EPSILON * scene.epsilon)
    change = float(np.interp(sigma**-0.5, nodes, along))
    return change, largest * (OFF + OFF_PER_EPSILON * scene.epsilon)


@lru_cache(maxsize=2)
def _errors(heat: bool) -> tuple[np.ndarray, PchipInterpolator]:
    """Nodes in 1/√σ, rising from 0, and the change in per cent over Re² there, over Re.

    For thin layers the change goes by powers of 1/√σ, so that two columns give that of σ → ∞.
    """
    table = np.genfromtxt(TABLE, delimiter=",", names=True)
    table = table[table["heat"] == heat]
    reynolds, sigma = np.unique(table["reynolds"]), np.unique(table["sigma"])[::-1]
    change = 100 * (table["resolved"] / table["averaged"] - 1) / table["reynolds"] ** 2
    change, nodes = change.reshape(len(reynolds), -1)[:, ::-1], sigma**-0.5
    slope = (change[:, 1] - change[:, 0]) / (nodes[1] - nodes[0])
    change = np.column_stack([change[:, 0] - slope * nodes[0], change])
    return np.append(0.0, nodes), PchipInterpolator(reynolds, change)

"""Error of the depth-averaged inertia and heat: a parabola stands for each profile across the gap.

An estimate, by second-order theory of small motion for a square piston: the mean force with the
velocity, and with heat the temperature, resolved across the gap, beside that of the depth-averaged
terms. The error grows as Re² at first and depends little on the squeeze number.
"""

from __future__ import annotations

from functools import lru_cache
from math import nan

import numpy as np
from scipy.interpolate import PchipInterpolator

from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import THICK_SIGMA

# Mean force over ε² in p0 times the pad's area: rows of Re, columns of σ, each depth-averaged and
# resolved across the gap. Isothermal; and with heat (Pr 0.71, γ 1.4, κ 0.7), there depth-averaged
# at ε = 0.005. At Re 40 the isothermal errors are 2.9 to 11 %, too far from those at 20 to be
# interpolated: at small σ the force has resonances in Re.
ISOTHERMAL = (
    (0.45, 1.0, 4.0, 10.0, 20.0),
    (20.0, 100.0, 600.0, 2400.0),
    (
        ((0.454341, 0.454341), (0.935660, 0.935644), (1.143986, 1.143963), (1.215690, 1.215665)),
        ((0.493860, 0.493858), (0.981968, 0.981878), (1.188342, 1.188218), (1.259155, 1.259020)),
        ((0.751807, 0.751028), (1.191320, 1.189308), (1.370745, 1.368333), (1.433356, 1.430802)),
        ((1.246234, 1.230387), (1.361494, 1.349038), (1.482961, 1.469510), (1.537860, 1.523457)),
        ((0.876133, 0.879553), (1.309841, 1.281206), (1.454073, 1.413234), (1.522382, 1.475872)),
    ),
)
WITH_HEAT = (
    (0.45, 1.8, 4.0, 7.0, 10.0),
    (25.0, 100.0, 600.0),
    (
        ((0.548788, 0.548770), (0.931476, 0.931437), (1.140541, 1.140493)),
        ((0.647614, 0.647391), (1.030767, 1.030241), (1.236497, 1.235836)),
        ((0.820882, 0.819119), (1.167905, 1.165028), (1.359611, 1.356232)),
        ((1.042750, 1.034657), (1.300174, 1.291199), (1.464962, 1.455187)),
        ((1.187152, 1.168694), (1.380771, 1.363363), (1.522284, 1.504336)),
    ),
)
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
    if reynolds > (MOST_REYNOLDS_THICK if thick else (WITH_HEAT if heat else ISOTHERMAL)[0][-1]):
        return nan, nan
    nodes, errors = _errors(heat)
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
    reynolds, sigma, forces = (np.array(each) for each in (WITH_HEAT if heat else ISOTHERMAL))
    averaged, resolved = np.moveaxis(forces, -1, 0)[:, :, ::-1]
    nodes = sigma[::-1] ** -0.5
    change = 100 * (resolved / averaged - 1) / reynolds[:, None] ** 2
    slope = (change[:, 1] - change[:, 0]) / (nodes[1] - nodes[0])
    change = np.column_stack([change[:, 0] - slope * nodes[0], change])
    return np.append(0.0, nodes), PchipInterpolator(reynolds, change)

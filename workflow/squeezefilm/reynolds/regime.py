"""Where the equation of a study is stretched, in per cent of the force.

Of what a study leaves out, inertia and slip move the mean force most. Notes say by how much, from
half a per cent on; they are estimates, not corrections.
"""

from __future__ import annotations

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.limits import limit_axis, limit_points, small_amplitude

LEAST_SHARE = 0.005
# Inertia's share of the mean force per unit of ρωh0²/μ: 4.4 % (centred) to 5.4 % (at the rim of the
# paper's disc) where the velocity across the gap was resolved, σ 146–2331, ε up to 0.4. The share
# grows more slowly beyond a tenth, and is not known for films that the gas flows out of freely.
INERTIA_SHARE = 0.047
INERTIA_MOST = 0.10
INERTIA_LEAST_SIGMA = 100.0
# First-order slip is meant for Knudsen numbers up to here (Burgdorfer 1959 for small ones).
SLIP_MOST_KNUDSEN = 0.1
GRID_TOLERANCE = 1e-2


def regime_notes(scene: Scene) -> list[str]:
    """Where the isothermal Reynolds equation of this study is stretched: inertia, rarefaction."""
    notes = (_inertia(scene), _slip(scene), _thin(scene))
    return [note for note in notes if note]


def _inertia(scene: Scene) -> str:
    share = INERTIA_SHARE * scene.modified_reynolds
    if share < LEAST_SHARE:
        return ""
    number = f"modified Reynolds number {scene.modified_reynolds:.2g}"
    if scene.sigma < INERTIA_LEAST_SIGMA:
        return f"inertia, left out, changes the force by an unknown share ({number})"
    if share > INERTIA_MOST:
        return f"inertia, left out, adds about {INERTIA_MOST:.0%} or more of the force ({number})"
    return f"inertia, left out, adds about {share:.1%} of the force ({number})"


def _slip(scene: Scene) -> str:
    if scene.gas.rarefaction != "none":
        return ""
    share, number = slip_share(scene), f"Kn {scene.knudsen:.2g}"
    if not abs(share) >= LEAST_SHARE:  # of no force at all it is not a number
        return ""
    change = "takes" if share < 0 else "adds"
    more = " or more" if scene.knudsen > SLIP_MOST_KNUDSEN else ""
    return f"slip, left out, {change} about {abs(share):.1%}{more} of the force ({number})"


def _thin(scene: Scene) -> str:
    if scene.gas.rarefaction != "slip" or scene.knudsen <= SLIP_MOST_KNUDSEN:
        return ""
    return (
        f"slip of first order is meant for Kn up to {SLIP_MOST_KNUDSEN:g}, fukui-kaneko for up to "
        f"0.17 (Kn {scene.knudsen:.2g})"
    )


def slip_share(scene: Scene) -> float:
    """What slip would change of the mean force, relative, to second order in ε; NaN of no force.

    Within a quarter of the solver's own difference up to ε = 0.4 and within a factor of 2.3 up to
    0.8 (sinc and piston, σ 2–2331). An ellipse is taken as the square inside it, any gap as flat,
    the finger as at rest.
    """
    side = np.sqrt(0.5) if scene.finger.shape == "ellipse" else 1.0
    nodes = [
        0.5
        + side * (limit_axis(limit_points(tolerance=GRID_TOLERANCE, sigma=sigma)).all_nodes - 0.5)
        for sigma in (scene.sigma, scene.sigma * scene.aspect**2)
    ]
    amplitude = scene.amplitude(*np.meshgrid(*nodes, indexing="ij"))
    with np.errstate(all="ignore"):
        viscous, slipping = small_amplitude(
            epsilon=np.full(2, 0.1),
            sigma=np.full(2, scene.sigma),
            amplitude=np.stack([amplitude, amplitude]),
            aspect=scene.aspect,
            slip=np.array([0.0, 6 * scene.knudsen]),
        ).mean
        return float(slipping / viscous - 1)

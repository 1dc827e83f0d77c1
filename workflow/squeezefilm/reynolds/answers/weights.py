"""What each answer weighs the overpressure with: it is the mean of both over pad and period.

Every weight is w₀ + w₁ sin T + w₂ cos T at every point, shape (3, Q), in the answer's unit, so that
the answer is ⟨w (P − 1)⟩. Forces are those of the gas on the finger; x and y are the actuator's
axes, z points from the surface to the finger. Lengths of the gap in units of h0.
"""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.answers.samples import Sample

FORCE = "force"
# Cosine moments along each side, and first harmonics of them, that stand by the answers: the change
# of an answer from grid to grid may be small by chance, that of all these hardly.
MOMENTS = 3
GUARD = "guard"


def weights_of(film: Sample) -> dict[str, np.ndarray]:
    """By the names in OUTPUTS (io/solution.py); ``force`` and the guards beside them."""
    scene = film.scene
    force = scene.force_scale_n
    one, nothing = np.ones_like(film.x), np.zeros_like(film.x)
    finger = scene.finger
    x, y = finger.turned((film.x - 0.5) * finger.length_x_m, (film.y - 0.5) * finger.length_y_m)
    _, sine, cosine = film.gap
    found = {
        FORCE: force * np.stack([one, nothing, nothing]),
        "moment_x": force * np.stack([y, nothing, nothing]),
        "moment_y": force * np.stack([-x, nothing, nothing]),
        # F₁ of F₀ + F₁ sin T + F₂ cos T is twice the mean with sin T.
        "force_sin": 2 * force * np.stack([nothing, one, nothing]),
        "force_cos": 2 * force * np.stack([nothing, nothing, one]),
        # −p ∂h/∂t, the work that the surface does against the pressure.
        "power": force
        * scene.h0_m
        * scene.actuator.angular_frequency_rad_per_s
        * np.stack([nothing, cosine, -sine]),
        **_thrust(film),
    }
    for k in range(MOMENTS):
        for n in range(MOMENTS):
            wave = np.cos(2 * np.pi * k * film.x) * np.cos(2 * np.pi * n * film.y)
            for part in range(3):
                weight = np.zeros((3, len(wave)))
                weight[part] = wave
                found[f"{GUARD} {k} {n} {part}"] = weight
    return {name: film.symmetric(weight) for name, weight in found.items()}


def _thrust(film: Sample) -> dict[str, np.ndarray]:
    """Shear at the finger's wall by the flow that pressure drives, and pressure on its slope.

    The shear is −(h/2) ∇p, in the mean over the pad ½ ⟨p ∇h⟩ as p vanishes on the rim, and the
    pressure pushes by −⟨p ∇g⟩ where the finger's own wall rises, g being the gap at rest.
    """
    finger, scene = film.scene.finger, film.scene
    lengths = finger.length_x_m, finger.length_y_m
    along_x, along_y = (
        slope / length * np.array([-0.5, 0.5, 0.5])[:, None]
        for slope, length in zip(film.slopes, lengths, strict=True)
    )
    turned = finger.turned(along_x, along_y)
    names = ("thrust_x", "thrust_y")
    force = scene.force_scale_n * scene.h0_m
    return {name: force * weight for name, weight in zip(names, turned, strict=True)}


def varies(weight: np.ndarray) -> bool:
    """Whether it asks for harmonics of the pressure, not for its mean alone."""
    return bool(np.any(weight[1:]))

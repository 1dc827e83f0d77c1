"""Mean force of a disc at small motion, the velocity resolved across the gap."""

import numpy as np
from scipy.special import iv

from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid


def resolved_second_order(sigma: float, reynolds: float, *, points: int = 60) -> float:
    """Mean pressure over p0 ε² of a piston at ε → 0, the velocity resolved across the gap.

    With lengths across the gap by h0 and the first order p, u, w of isothermal gas, in e^(iT), the
    mean velocity u₂ of the second order obeys

        ∂²u₂/∂z² = (12/σ) ∂p₂/∂r + Re ⟨p ∂u/∂T + u ∂u/∂r + w ∂u/∂z⟩,     ∫u₂ dz + ⟨p ∫u dz⟩ = 0,

    u₂ = 0 at z = 0 and −⟨h ∂u/∂z⟩ at z = 1; no gas crosses a circle in the mean.
    """
    across, along = chebyshev_grid(points), chebyshev_grid(points)
    z, r, q = across.x, along.x[:, None] / 2, np.sqrt(1j * reynolds) / 2
    # u = −(12/σ) ∂p/∂r φ(z), and what ∫u dz has of that.
    turned = q * (2 * z - 1)
    phi = (1 - np.cosh(turned) / np.cosh(q)) / (1j * reynolds)
    slope = -2 * q * np.sinh(turned) / np.cosh(q) / (1j * reynolds)
    inside = (z - (np.sinh(turned) + np.sinh(q)) / (2 * q * np.cosh(q))) / (1j * reynolds)
    decay = np.sqrt(1j * sigma / (12 * inside[-1]))
    edge_value = iv(0, decay / 2)
    p = iv(0, decay * r) / edge_value - 1
    dp = decay * iv(1, decay * r) / edge_value
    u, rate = -12 / sigma * dp * phi, 1j * p
    divergence = -12 / sigma * decay**2 * (p + 1)
    curl = np.where(r > 0, dp / np.where(r > 0, r, 1), decay**2 / 2 / edge_value)
    du = -12 / sigma * (decay**2 * (p + 1) - curl) * phi
    w = -(rate * z + divergence * inside)

    def mean(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.real(a * np.conj(b)) / 2

    shear = -12 / sigma * dp * slope
    force = reynolds * (mean(p, 1j * u) + mean(u, du) + mean(w, shear))
    flow = -mean(np.ones(1), shear[:, -1]) / 2 - force @ (across.weights * z * (1 - z) / 2)
    flow += mean(p[:, 0], u @ across.weights)
    # ∫u₂ dz has −(1/σ) ∂p₂/∂r: the rest of it, and the mean over the disc by parts.
    return float(-4 * sigma * (along.weights / 2 * r[:, 0] ** 2) @ flow)

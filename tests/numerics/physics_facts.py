"""Values that are known apart from every solver of this repository, each with its source.

Forces are means over a period in units of p0 times the pad's area, unless they end in _N.
Profiles are the piston, s = 1, and the paper's sinc(109.8 r) in the middle of a square pad.
"""

import math

import numpy as np

# Blech (1983), small motion of a square piston: force −ε (S sin T + D cos T).
CUT_OFF_SIGMA = 21.6349
SPRING_AT_CUT_OFF = DAMPING_AT_CUT_OFF = 0.3658385
SPRING_AT_20, DAMPING_AT_20 = 0.3390888408, 0.3644581
SLOW_SPRING = 0.00170251052
"""S/σ² for σ → 0."""

# The centred sinc. Second order: F/ε² for ε → 0 by σ, two linear solves by an independent program.
SINC_SECOND_ORDER = {20.0: 0.2240822625, 583.0: 0.4521765445, 2331.0: 0.4544710516}
# σ → ∞ by ε, one Laplace solve: ψ² harmonic and 1 + 3/2 ε² s² on the rim.
SINC_FAST = {0.1: 0.0045767166, 0.44: 0.0951846761}
# Converged at ε = 0.44, by σ, on whose ten digits two independent programs agree.
SINC_CONVERGED = {583.0: 0.0945747144, 2331.0: 0.0949461577}

# The paper's actuator, by two independent programs: gap, amplitude and place of the pad along x.
CENTRED_N = 0.9620420
"""At 5 µm and 2.2 µm in the middle, where the paper's finite elements give 0.99 N."""
ASIDE_N = 0.7075753
"""At 5 µm and 2 µm, 2.9 mm aside."""


def piston_response(sigma: float, aspect: float = 1.0) -> tuple[float, float]:
    """S and D of a rectangular piston: Blech's double series over odd numbers, good to 1e-5."""
    odd = np.arange(1, 400, 2)
    m, n = np.meshgrid(odd, odd, indexing="ij")
    wave = np.pi**2 * (m**2 + (n / aspect) ** 2)
    share = 64 / (np.pi**4 * m**2 * n**2) * sigma / (wave**2 + sigma**2)
    return float(np.sum(share * sigma)), float(np.sum(share * wave))


def slow_piston(epsilon: float, sigma: float) -> float:
    """σ → 0 at any ε: (5/2) σ² ⟨Ḣ²/H⁶⟩ times SLOW_SPRING."""
    phase = 2 * np.pi * np.arange(256) / 256
    rate = (epsilon * np.cos(phase)) ** 2 / (1 + epsilon * np.sin(phase)) ** 6
    return float(2.5 * sigma**2 * rate.mean() * SLOW_SPRING)


def fast_piston(epsilon: float) -> float:
    """σ → ∞: √((1 + 3/2 ε²)/(1 − ε²)) − 1, the paper's equation (6)."""
    return math.sqrt((1 + 1.5 * epsilon**2) / (1 - epsilon**2)) - 1

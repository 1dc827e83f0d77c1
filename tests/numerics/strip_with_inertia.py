"""The film with inertia under an infinitely long finger: its periodic state by dense collocation.

With w = HP = ∂X/∂x and flux w ū = −∂X/∂T mass is conserved by itself, and the one-mode momentum
equation is one equation for X between the rim, where P = 1, and the middle, where X = 0.
"""

import numpy as np

from squeezefilm.reynolds.asymptotics.edge_layer import all_weights
from squeezefilm.reynolds.spectral import axis, period

SINC_ALONG = 1.098


def strip_mean(
    *,
    epsilon: float,
    sigma: float,
    reynolds: float,
    slip: float = 0.0,
    points: int = 48,
    instants: int = 20,
    wave_number: float = SINC_ALONG,
) -> float:
    """Mean overpressure under −½ … ½ of the profile sinc(wave_number x), in units of p0.

    Slip of first order makes gas flow (1 + slip/w) times as freely and inertia (1 + ⅔ slip/w) times
    as large; the iteration's Jacobian leaves it out.
    """
    line, time = axis(points, False), period(instants)
    # Nodes are drawn to the rim at 0, whose layer is √(2/σ) wide.
    stretch = max(0.5, 1.2 * np.log(np.sqrt(sigma) / 25))
    x = np.expm1(stretch * line.all_nodes) / np.expm1(stretch) / 2
    step = stretch * np.exp(stretch * line.all_nodes) / np.expm1(stretch) / 2
    first = line.derivative / step[:, None]
    second, rate = first @ first, time.derivative
    s, sine = np.sinc(wave_number * (0.5 - x))[:, None], np.sin(time.nodes)
    gap, gap_slope = 1 + epsilon * s * sine, epsilon * (first @ s) * sine
    inertia = reynolds / 10 * gap
    still = float(np.sqrt(1 + 1.5 * (epsilon * s[0, 0]) ** 2))
    stream = np.zeros_like(gap)
    count = points + 1
    at, now = np.arange(count), np.arange(instants)
    for _ in range(40):
        mass, slope, flux = still + first @ stream, second @ stream, -stream @ rate.T
        flux_rate, mass_rate = flux @ rate.T, mass @ rate.T
        residual = gap * mass * slope - mass**2 * gap_slope
        residual *= (1 + slip / mass) / sigma
        residual += flux + inertia * (1 + 2 / 3 * slip / mass) * (
            mass * flux_rate - 17 / 7 * flux * mass_rate - 9 / 7 * flux**2 / mass * slope
        )
        residual[0] = mass[0] - gap[0]
        of_mass = inertia * (flux_rate + 9 / 7 * (flux / mass) ** 2 * slope)
        of_mass += (gap * slope - 2 * mass * gap_slope) / sigma
        of_slope = gap * mass / sigma - 9 / 7 * inertia * flux**2 / mass
        of_flux = 1 - inertia * (17 / 7 * mass_rate + 18 / 7 * flux * slope / mass)
        jacobian = (-17 / 7 * inertia * flux)[:-1, :, None, None] * first[:-1, None, :-1, None]
        jacobian = jacobian * rate[None, :, None, :]
        by_mass = of_mass[:-1, :, None] * first[:-1, None, :-1]
        by_mass += of_slope[:-1, :, None] * second[:-1, None, :-1]
        jacobian[:, now, :, now] += by_mass.swapaxes(0, 1)
        jacobian[at, :, at, :] -= of_flux[:-1, :, None] * rate
        jacobian[at, :, at, :] -= (inertia * mass)[:-1, :, None] * (rate @ rate)
        jacobian[0] = 0.0
        jacobian[0, now, :, now] = first[0, :-1]
        size = count * instants
        change = np.linalg.solve(jacobian.reshape(size, size), residual[:-1].ravel())
        change = change.reshape(count, instants)
        stream[:-1] -= change
        if np.abs(first[:, :-1] @ change).max() < 1e-9:
            mean = (still + first @ stream) / gap - 1
            return float(2 * all_weights(line) * step @ mean.mean(axis=1))
    raise ArithmeticError("the strip's periodic state did not converge")

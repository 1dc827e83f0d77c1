"""Inertia and heat of the gas in a strip whose wall slides, profiles resolved across the gap.

Independent of squeezefilm: momentum and energy in the lubrication approximation, collocated on
Chebyshev nodes across the gap and along the strip, Fourier nodes over the period. With ζ = z/H,
dζ/dT = W, lengths by the strip's, time by 1/ω, temperature rise θ over the ambient temperature:

    Re ρ (∂u/∂T + u ∂u/∂X + W ∂u/∂ζ) = −(12/σ) ∂P/∂X + ∂/∂ζ(μ ∂u/∂ζ)/H²
    Re Pr ρ (∂θ/∂T + u ∂θ/∂X + W ∂θ/∂ζ) = β (∂P/∂T + u ∂P/∂X) + ∂/∂ζ(μ ∂θ/∂ζ)/H²
                                           + (β σ/12) μ (∂u/∂ζ)²/H²
    ∂(ρH)/∂T + ∂(ρHu)/∂X + ∂(ρHW)/∂ζ = 0,    ρ = P/(1 + θ),    μ = (1 + θ)^κ

u is 2Λ/σ on the sliding wall, 0 on the other, θ and W are 0 on both, P is 1 at the ends. Gas comes
in with the profile that it has without inertia, and at the ambient temperature.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

ROUNDS, TOLERANCE, CHANGE = 60, 1e-10, 1e-9
# Rounds after which the places of inflow stay, and those that are mixed.
SETTLED, DEPTH = 6, 12
# Seeds of ``vibrating_strip``, from the first.
VIBRATING = 6000


class NotConvergedError(Exception):
    """The film has no such state, or iteration does not find it."""


@dataclass(frozen=True)
class Strip:
    """A film; ``tilt`` is the rise of the gap along the strip and ``epsilon`` its amplitude."""

    sigma: float
    bearing: float
    reynolds: float = 0.0
    heating: float = 0.0
    tilt: float = 0.0
    epsilon: float = 0.0
    prandtl: float = 0.71
    exponent: float = 0.7
    nodes: int = 32
    across: int = 14
    times: int = 1


def chebyshev(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes on 0 … 1 and the matrix of the first derivative (Trefethen 2000)."""
    k = np.arange(count)
    x = np.cos(np.pi * k / (count - 1))
    c = np.where(k % (count - 1) == 0, 2.0, 1.0) * (-1.0) ** k
    matrix = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(count))
    matrix -= np.diag(matrix.sum(axis=1))
    return (1 - x) / 2, -2 * matrix


def fourier(count: int) -> np.ndarray:
    """Derivative over the period 2π on an odd number of nodes."""
    k = np.arange(count)
    difference = np.pi * (k[:, None] - k) / count
    sign = (-1.0) ** (k[:, None] - k)
    off = 0.5 * sign / np.where(difference == 0, 1, np.sin(difference))
    return np.where(difference == 0, 0.0, off)


class Film:
    """The operators of a strip and its state; fields are (across, x, t), or (x, t)."""

    def __init__(self, strip: Strip) -> None:
        self.strip = strip
        self.x, self.d_x = chebyshev(strip.nodes)
        self.zeta, self.d_z = chebyshev(strip.across)
        self.d_t = fourier(strip.times)
        self.t = 2 * np.pi * np.arange(strip.times) / strip.times
        self.gap = 1 + strip.tilt * (self.x - 0.5)[:, None] + strip.epsilon * np.sin(self.t)
        # From 0 to ζ, by the derivative's inverse; its last row are the weights of the mean.
        self.integral = np.zeros_like(self.d_z)
        self.integral[1:, 1:] = np.linalg.inv(self.d_z[1:, 1:])
        self.weights = self.integral[-1]
        along = np.zeros_like(self.d_x)
        along[1:, 1:] = np.linalg.inv(self.d_x[1:, 1:])
        self.along = along[-1]
        self.inflow, self.inflow_stays = np.zeros(0, dtype=bool), False
        self.slide = 2 * strip.bearing / strip.sigma

    def by_x(self, values: np.ndarray) -> np.ndarray:
        return np.einsum("ij,...jt->...it", self.d_x, values)

    def by_t(self, values: np.ndarray) -> np.ndarray:
        return values @ self.d_t.T

    def by_z(self, values: np.ndarray) -> np.ndarray:
        return np.einsum("ij,jxt->ixt", self.d_z, values)

    def mean_across(self, values: np.ndarray) -> np.ndarray:
        return np.einsum("z,zxt->xt", self.weights, values)

    def reynolds(self, flux: np.ndarray, stored: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """Pressure of the film equation to which a flux and a stored mass are added."""
        strip, shape, inner = self.strip, pressure.shape, np.s_[1:-1]
        slope = np.kron(self.d_x, np.eye(strip.times))
        rate = np.kron(np.eye(strip.nodes), self.d_t)
        cube, gap = (self.gap**3).ravel(), self.gap.ravel()
        inside = np.zeros(shape, dtype=bool)
        inside[inner] = True
        free = inside.ravel()
        added = strip.sigma * (slope @ flux.ravel() + rate @ stored.ravel())
        p = pressure.ravel().copy()
        for _ in range(30):
            convected = strip.sigma * rate + strip.bearing * slope
            rest = slope @ (cube * p * (slope @ p)) - convected @ (gap * p) - added
            jacobian = (
                slope @ ((cube * p)[:, None] * slope + np.diag(cube * (slope @ p)))
                - convected * gap
            )
            step = np.linalg.solve(jacobian[np.ix_(free, free)], -rest[free])
            p[free] += step
            if np.abs(step).max() < TOLERANCE:
                return p.reshape(shape)
        raise NotConvergedError("Newton's method for the film equation")

    def between_walls(
        self,
        right: np.ndarray,
        viscosity: np.ndarray,
        inertia: tuple[np.ndarray, ...],
        rim: np.ndarray,
    ) -> np.ndarray:
        """Solve a ∂f/∂T + b ∂f/∂X + c ∂f/∂ζ − ∂/∂ζ(μ ∂f/∂ζ) = right, f = rim on both walls.

        ``inertia`` is a, b, c; where b leads into the strip f is ``rim`` at its ends too.
        """
        across, along, times = right.shape
        operator = np.zeros((across, along, times, across, along, times))
        x, t, z = np.arange(along), np.arange(times), np.arange(across)
        a, b, c = inertia
        # Indices kept on both sides are the axes along which an operator is diagonal.
        friction = np.einsum("ij,jxt,jk->xtik", self.d_z, viscosity, self.d_z)
        up = np.einsum("ixt,ik->xtik", c, self.d_z) - friction
        for i in x:
            for j in t:
                operator[:, i, j, :, i, j] += up[i, j]
        for i in z:
            for j in t:
                operator[i, :, j, i, :, j] += b[i, :, j, None] * self.d_x
            for j in x:
                operator[i, j, :, i, j, :] += a[i, j, :, None] * self.d_t
        prescribed = np.zeros(right.shape, dtype=bool)
        prescribed[[0, -1]] = True
        if not self.inflow_stays:
            self.inflow = np.zeros(right.shape, dtype=bool)
            self.inflow[:, 0], self.inflow[:, -1] = b[:, 0] > 0, b[:, -1] < 0
        prescribed |= self.inflow
        known = prescribed.ravel()
        matrix = operator.reshape(known.size, known.size)
        found = np.where(known, rim.ravel(), 0.0)
        free = ~known
        rest = (right.ravel() - matrix @ found)[free]
        found[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest)
        return found.reshape(right.shape)

    def profiles(
        self, p: np.ndarray, u: np.ndarray, theta: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Velocity and temperature rise that go with a pressure and with the last profiles."""
        strip, gap = self.strip, self.gap
        density = p / (1 + theta)
        mass = gap * density
        mass_rate = self.by_t(mass) + self.by_x(mass * u)
        w = -np.einsum("ij,jxt->ixt", self.integral, mass_rate) / mass
        viscosity = (1 + theta) ** strip.exponent
        slope = self.by_x(p)

        lag = strip.reynolds * density * gap**2
        inertia = tuple(lag * each for each in (np.ones_like(u), u, w))
        shear = self.by_z(u)
        heat = strip.heating * (
            gap**2 * (self.by_t(p) + u * slope) + strip.sigma / 12 * viscosity * shear**2
        )
        warm = tuple(strip.prandtl * each for each in inertia)
        drive = np.broadcast_to(-(gap**2) * 12 / strip.sigma * slope, u.shape)
        plain = self.plain_profile(slope)
        return (
            self.between_walls(drive, viscosity, inertia, plain),
            self.between_walls(heat, viscosity, warm, 0 * u),
        )

    def plain_profile(self, slope: np.ndarray) -> np.ndarray:
        """Velocity without inertia and heat."""
        parabola = 6 * self.zeta * (1 - self.zeta)
        couette = self.slide * (1 - self.zeta)[:, None, None]
        return couette - parabola[:, None, None] * self.gap**2 / self.strip.sigma * slope

    def added(
        self, p: np.ndarray, u: np.ndarray, theta: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Flux and stored mass beyond those of the film equation at this pressure."""
        mass = self.gap * p / (1 + theta)
        plain = self.gap * p * (self.slide / 2 - self.gap**2 / self.strip.sigma * self.by_x(p))
        return self.mean_across(mass * u) - plain, self.mean_across(mass) - self.gap * p

    def base(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pressure and profiles without inertia and heat."""
        zero = np.zeros_like(self.gap)
        p = self.reynolds(zero, zero, zero + 1)
        u = self.plain_profile(self.by_x(p))
        return p, u, 0 * u

    def averaged(
        self, p: np.ndarray, flux: np.ndarray | float = 0.0, stored: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """Return the pressure with the solver's terms of inertia and heat, and with added ones.

        They are those of the flow by pressure (squeezefilm/reynolds/terms: inertia, thermal).
        """
        strip, gap, one = self.strip, self.gap, np.eye(self.gap.size)
        rate = np.kron(np.eye(strip.nodes), self.d_t)
        slope = np.kron(self.d_x, np.eye(strip.times))

        def solve(operator: np.ndarray, lag: np.ndarray, right: np.ndarray) -> np.ndarray:
            matrix = one + lag.ravel()[:, None] * operator
            return np.linalg.solve(matrix, right.ravel()).reshape(gap.shape)

        def improved(state: np.ndarray) -> np.ndarray:
            p, u = state.reshape(2, *gap.shape)
            mass, driven = gap * p, -(gap**2) / strip.sigma * self.by_x(p)
            lag, filling = strip.reynolds / 10 * mass * gap, self.by_t(mass) / mass
            carried = rate + 9 / 7 * u.ravel()[:, None] * slope - np.diag(filling.ravel()) / 7
            u = solve(carried, lag, driven)
            compressed = strip.heating / 12 * gap**2 * self.by_t(p)
            warm = solve(rate, strip.prandtl * lag, compressed)
            cool = strip.heating * strip.sigma * u**2 / 20
            hot = warm - cool
            thicker = strip.exponent * (3 / 5 * warm - 3 / 7 * cool)
            beside = lag * (9 / 7 * hot * self.by_t(u) + u * self.by_t(hot) / 7)
            beside -= u * (6 / 5 * warm - 9 / 14 * cool + thicker)
            added = mass * (u - driven + beside) + flux
            return np.stack([self.reynolds(added, stored - mass * hot, p), u]).ravel()

        start = np.stack([p, -(gap**2) / strip.sigma * self.by_x(p)])
        return fixed_point(improved, start.ravel(), gap.size)[: gap.size].reshape(gap.shape)

    def thrust(self, u: np.ndarray, theta: np.ndarray) -> float:
        """Mean shear of the wall at rest, in p0 h0 over the strip's length."""
        shear = (1 + theta[-1]) ** self.strip.exponent * self.by_z(u)[-1]
        return float(self.along @ (-self.strip.sigma / 12 * shear / self.gap).mean(axis=-1))

    def force(self, p: np.ndarray) -> float:
        """Mean overpressure over strip and period."""
        return float(self.along @ (p - 1).mean(axis=-1))


def fixed_point(
    improved: Callable[[np.ndarray], np.ndarray],
    state: np.ndarray,
    size: int,
    settle: Callable[[], None] = lambda: None,
) -> np.ndarray:
    """Return the state that is its own improvement, to CHANGE in its first ``size`` numbers.

    By Anderson's mixing of the last rounds.
    """
    states: list[np.ndarray] = []
    moves: list[np.ndarray] = []
    for k in range(ROUNDS):
        if k == SETTLED:
            settle()
            states, moves = [], []
        move = improved(state) - state
        if np.abs(move[:size]).max() < CHANGE:
            return state + move
        states, moves = [*states[-DEPTH:], state], [*moves[-DEPTH:], move]
        state = state + move
        if len(states) > 1:
            by_state, by_move = np.diff(states, axis=0).T, np.diff(moves, axis=0).T
            state = state - (by_state + by_move) @ np.linalg.lstsq(by_move, move, rcond=1e-12)[0]
    raise NotConvergedError("profiles and pressure")


def forces(strip: Strip) -> tuple[float, float]:
    """Mean overpressure without inertia and heat, and with them."""
    film, (p, _, _) = resolved(strip)
    return film.force(film.base()[0]), film.force(p)


def resolved(strip: Strip) -> tuple[Film, list[np.ndarray]]:
    """Return a strip and its pressure, velocity and temperature rise."""
    film = Film(strip)
    fields = film.base()
    sizes = [each.size for each in fields]

    def improved(state: np.ndarray) -> np.ndarray:
        parts = np.split(state, np.cumsum(sizes)[:2])
        p, u, theta = (a.reshape(b.shape) for a, b in zip(parts, fields, strict=True))
        with np.errstate(all="ignore"):
            u, theta = film.profiles(p, u, theta)
            flux, stored = film.added(p, u, theta)
        if not (np.isfinite(flux).all() and np.abs(theta).max() < 1):
            raise NotConvergedError("profiles")
        return np.concatenate([each.ravel() for each in (film.reynolds(flux, stored, p), u, theta)])

    def settle() -> None:
        film.inflow_stays = True

    start = np.concatenate([each.ravel() for each in fields])
    state = fixed_point(improved, start, sizes[0], settle)
    parts = np.split(state, np.cumsum(sizes)[:2])
    return film, [part.reshape(field.shape) for part, field in zip(parts, fields, strict=True)]


def between(random: np.random.Generator, least: float, most: float) -> float:
    """A number that is uniform in its logarithm."""
    return float(np.exp(random.uniform(np.log(least), np.log(most))))


def random_strip(seed: int) -> Strip:
    """A strip whose nodes resolve the layer at the inlet in which gas warms; a third vibrates."""
    random = np.random.default_rng(seed)

    while True:
        vibrates = random.uniform() < 0.35
        bearing = between(random, 0.03, 10) * random.choice([-1, 1])
        level = vibrates and random.uniform() < 0.4
        tilt = 0.0 if level else random.uniform(0.2, 1.3) * random.choice([-1, 1])
        shear_reynolds = between(random, 0.05, 2) / (1 + abs(bearing))
        if shear_reynolds < (0.08 if vibrates else 0.05):
            continue
        sigma, epsilon, reynolds = 2 * abs(bearing), 0.0, shear_reynolds
        if vibrates:
            sigma = between(random, 5, 300)
            epsilon = random.uniform(0.1, 0.6) * (1 - abs(tilt) / 2)
            reynolds = shear_reynolds * sigma / (2 * abs(bearing))
            if reynolds > 3 or epsilon * reynolds > 1:
                continue
        heating = (1 - 1 / 1.4) * 0.71 * reynolds
        size = {"nodes": 18, "across": 8, "times": 7} if vibrates else {"nodes": 24, "across": 10}
        return Strip(sigma, bearing, reynolds, heating, tilt, epsilon, **size)


def vibrating_strip(seed: int) -> Strip:
    """A strip that vibrates, most of them hardly, under a pad that may slide fast."""
    random = np.random.default_rng(seed)

    while True:
        bearing = between(random, 0.5, 10) * random.choice([-1, 1])
        tilt = random.uniform(0.1, 1.2) * random.choice([-1, 1])
        shear_reynolds = between(random, 0.08, 1.5) / (1 + abs(bearing))
        sigma = between(random, 5, 300)
        epsilon = between(random, 0.003, 0.6) * (1 - abs(tilt) / 2)
        reynolds = shear_reynolds * sigma / (2 * abs(bearing))
        if 0.3 < reynolds < 8 and epsilon * reynolds < 1:
            heating = (1 - 1 / 1.4) * 0.71 * reynolds
            size = {"nodes": 18, "across": 8, "times": 5 if epsilon < 0.05 else 7}
            return Strip(sigma, bearing, reynolds, heating, tilt, epsilon, **size)


def row_of(seed: int) -> dict[str, float]:
    """A strip with its change of the mean overpressure by inertia and heat.

    ``at_rest_missed`` is what the solver's averages across the gap miss of it for a wall at rest.
    """
    strip = vibrating_strip(seed) if seed >= VIBRATING else random_strip(seed)
    plain, both = forces(strip)
    missed = 0.0
    if strip.epsilon:
        still = replace(strip, bearing=0.0)
        at_rest, film = forces(still), Film(still)
        missed = at_rest[1] - film.force(film.averaged(film.base()[0]))
    names = "sigma", "bearing", "reynolds", "tilt", "epsilon", "nodes", "across", "times"
    numbers = {name: getattr(strip, name) for name in names}
    return {"seed": seed, **numbers, "resolved_change": both - plain, "at_rest_missed": missed}


if __name__ == "__main__":
    for number in map(int, sys.argv[1:]):
        try:
            print(*row_of(number).values(), sep=",")
        except (NotConvergedError, np.linalg.LinAlgError, ValueError) as reason:
            print(f"# {number}: no state: {reason}")

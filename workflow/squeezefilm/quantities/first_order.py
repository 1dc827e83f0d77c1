"""Effects that the film equation neglects, each at first order about a film's own state.

An effect is a source of mass S in J w = S, or a flow whose divergence is one: the adjoint λ
(adjoint.py) gives what it does to the mean pressure, and no source is formed.
"""

from dataclasses import replace
from math import cos, radians, sin

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.adjoint import Fields, along_x, along_y, dot, response, total
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.terms.rarefaction import slip_flow
from squeezefilm.reynolds.terms.thermal import JUMP_WARMS, temperature_jump

# Of the edge loss' coefficient C: kinetic energy of a plug and of a parabola, over that of the mean
# velocity.
EDGE_LOSS_LEAST, EDGE_LOSS_MOST = 1.0, 1.54
# Of the pad's length along x, from one state to the next whose differences are derivatives; the
# states' tolerance, and the residual, over its size at the start, of what is differentiated again.
STEP = 5e-3
STATE_TOLERANCE, TOLERANCE = 1e-8, 1e-7


class Answers:
    """Responses of the mean pressure to sources, by the adjoint state λ.

    Attributes:
        slope: of λ, by the adjoint of the grid's own divergence: the ``total`` of that times a flux
            is the answer to a source that is its divergence.
        rate: the answer to a source −∂stored/∂T is the ``total`` of that and what is stored.
        along: ``slope`` times ∇P.
    """

    def __init__(self, films: Fields, sensitive: np.ndarray) -> None:
        """Args: sensitive: λ at the unknowns."""
        weighted = films.on_all_nodes(sensitive) * films.plain_weights
        x = films.along_x.of_odd / films.lengths[0]
        y = films.along_y.of_odd / films.lengths[1]
        self.slope = np.stack([along_x(x.T, weighted), along_y(y.T, weighted)])
        self.rate = films.t_derivative(weighted * films.area)
        self.along = dot(self.slope, films.slope)


def by_slip(scenes: list[Scene], films: Fields, answers: Answers) -> tuple[np.ndarray, np.ndarray]:
    """Change by rarefaction, and by what it lacks of the flow factor.

    The source of a flow c H² F ∇P is −∇· of that. Films without slip get the flow factor's effect,
    and lack nothing.
    """
    inverse = films.number(np.array([scene.inverse_knudsen for scene in scenes]))
    factor = slipping = 6 / inverse * slip_flow(inverse * films.mass)
    if scenes[0].gas.rarefaction == "slip":
        slipping = films.number(films.problems.numbers["flow"][:, 1])
    square = films.gap**2
    return (
        -total(answers.along, square * slipping),
        total(answers.along, square * (slipping - factor)),
    )


def by_inertia(scenes: list[Scene], films: Fields, answers: Answers) -> np.ndarray:
    """Change by inertia of the gas, at first order in the modified Reynolds number.

    The velocity is taken as a parabola across the gap and the momentum equation is weighted with
    it, as Ruyer-Quil and Manneville (Eur. Phys. J. B 15, 2000) do for a liquid film. With the mean
    velocity ū and the velocity V that pressure alone would drive this reads

        ū + (Re ρ H²/10) {∂ū/∂T + (9/7)(ū·∇)ū − (1/7) ū ∂/∂T ln(Hρ)} = V,

    so that the velocity falls short of V by the second term at ū = V.
    """
    v = films.velocity
    slips = [scene.gas.rarefaction != "none" for scene in scenes]
    knudsen = np.array([scene.slip_knudsen or scene.knudsen for scene in scenes]) * slips
    # Re ρ H²/10 with what slip makes of it, over Re/10.
    lag = films.gap * (films.mass + 4 * films.number(knudsen))
    rate = np.stack([films.t_derivative(v[0]), films.t_derivative(v[1])])
    shortfall = total(dot(answers.slope, rate + 9 / 7 * films.carried(v)), lag * films.mass)
    mass_rate = films.gap_rate * films.density
    mass_rate = mass_rate + films.gap * films.pressure_rate * films.density_slope
    shortfall -= total(dot(answers.slope, v), lag * mass_rate) / 7
    return -films.problems.numbers["sigma"] * _reynolds(scenes) / 10 * shortfall


def by_thermal(scenes: list[Scene], films: Fields, answers: Answers) -> np.ndarray:
    """Change by thermal effects of an isothermal film whose walls stay at ambient temperature.

    Compression heats the gas by a = ∂P/∂T and friction by b = σ|ū|²/H², and conduction across the
    gap takes it away. With β = ((γ − 1)/γ) Pr Re the gas is warmer by β H² (a/12 − b/20) of the
    ambient temperature in the mean over the gap: so much less gas is in it, and the flow through it
    changes by its density and viscosity. Beside slip its temperature jumps at the walls
    (terms/thermal.py), and compression warms it more by 6 jumps.
    """
    gases = [scene.gas for scene in scenes]
    heating = _reynolds(scenes) * [(1 - 1 / gas.heat_capacity_ratio) * gas.prandtl for gas in gases]
    exponent = np.array([gas.viscosity_exponent for gas in gases])
    jump = films.number(np.array([temperature_jump(scene) for scene in scenes]))
    sigma = films.problems.numbers["sigma"]
    # Times mass per area and H², with which go the flow that is lost and the gas that is missing.
    compression = films.mass * films.gap**2 * films.pressure_rate
    compression *= 1 + JUMP_WARMS * jump / films.mass
    friction = films.mass * dot(films.velocity, films.velocity) / films.area  # over σ
    # Lighter gas, and more viscous.
    by_compression = 6 / 60 + exponent * 3 / 60
    by_friction = 18 / 280 + exponent * 3 / 140
    lost = answers.along * films.mobility  # of a flow −σū
    slower = by_friction * sigma * total(lost, friction) - by_compression * total(lost, compression)
    missing = total(answers.rate, compression) / 12 - sigma * total(answers.rate, friction) / 20
    return sigma * heating * missing - heating * slower


def by_edge_loss(scenes: list[Scene], films: Fields, answers: Answers) -> np.ndarray:
    """Change by the edge loss for C = 1: gas that flows in has come from rest.

    P = 1 − C (σ Re/24) ū_n² where gas flows in (Bernoulli), P = 1 where it flows out. C is 1 for a
    plug, 1.54 for a parabola, and more with losses: a bound of what can be known without the
    outside. On the rim ρ is 1, and λ is 0: of the flow only that across it counts.
    """
    weights = films.weights.reshape(films.gap.shape[1:])
    axes = [(along_x, films.grid.x, films.along_x), (along_y, films.grid.y, films.along_y)]
    with_rims = axes[:1] if films.grid.outline else axes
    fallen = np.zeros(len(scenes))
    for end, inwards in ((slice(1), 1.0), (slice(-1, None), -1.0)):
        for k, (along, axis, with_rim) in enumerate(with_rims):
            if inwards < 0 and axis.folded:
                continue
            rim, to_rim = (slice(None),) * k + (end,), with_rim.of_even.T[end] / films.lengths[k]
            mean = weights[rim] - sum(
                along(to_rim, answers.slope[k] * factor) * rise[:, *rim]
                for factor, rise, _ in films.flow_terms
            )
            inflow = np.maximum(inwards * films.velocity[k][:, *rim], 0.0)
            fallen += total(inflow**2 / films.area[end], mean)
    return -films.problems.numbers["sigma"] * _reynolds(scenes) / 24 * fallen


def _reynolds(scenes: list[Scene]) -> np.ndarray:
    return np.array([scene.modified_reynolds for scene in scenes])


def by_sliding(scenes: list[Scene], grid: Grid, *, device: Device) -> tuple[np.ndarray, np.ndarray]:
    """Change by the bearing term, at every order, and by the profile that moves past the pad.

    Both relative to the force, from states beside the scene's own: the pad at rest, and at the
    five places of ``line``.
    """

    def solved(some: list[Scene]) -> Fields:
        problems = problems_of(some, grid)
        states = solve_batch(some, grid, tolerance=STATE_TOLERANCE, device=device)
        failed = (states.status != 0)[:, None, None, None]
        return Fields(problems, grid, np.where(failed, np.nan, states.overpressure))

    rest = solved([at_rest(scene) for scene in scenes])
    films = [solved(list(some)) for some in zip(*map(line, scenes), strict=True)]
    force = films[2].mean(films[2].overpressure)
    first, second = by_passing(films, np.array([scene.bearing_number for scene in scenes]))
    return (force - rest.mean(rest.overpressure)) / force, (first + second) / force


def at_rest(scene: Scene) -> Scene:
    """The same pad, not sliding."""
    return replace(scene, pad=replace(scene.pad, speed_x_m_per_s=0.0))


def line(scene: Scene) -> list[Scene]:
    """The pad at five places a STEP apart along its own x axis, its own the middle one."""
    turn, length_m = radians(scene.pad.rotation_deg), STEP * scene.pad.length_x_m
    x_m, y_m = length_m * cos(turn), length_m * sin(turn)
    return [replace(scene, x_m=scene.x_m + k * x_m, y_m=scene.y_m + k * y_m) for k in range(-2, 3)]


def by_passing(films: list[Fields], bearing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second order of the mean pressure's change by the profile that passes.

    The bearing number Λ has the speed of the surface past the pad, whose place c on the surface
    therefore falls, by 2Λ/σ per T. ∂/∂T of the film seen from the pad is then ∂/∂T − (2Λ/σ)
    ∂/∂c, the second part of which is neglected for a profile that stands. To second order, since at
    the middle of a symmetric profile the first vanishes:

        J w1 = −2Λ ∂(Hρ)/∂c,     J w2 = −2Λ ∂w1/∂c − ½ R''(w1, w1).

    Args:
        films: at the places of ``line``, of an isothermal gas.
    """
    here = films[2]
    rate = -here.number(bearing) / STEP * here.area

    def first(k: int) -> np.ndarray:
        pushed = rate * (films[k + 1].mass - films[k - 1].mass)
        return response(films[k], pushed[films[k].inner], tolerance=TOLERANCE)

    back, middle, forward = first(1), first(2), first(3)
    per_mass = 1 / (here.gap * here.density_slope)
    curved = _curvature_of_flow(here, here.on_all_nodes(middle) * per_mass)[here.inner]
    pushed = rate * here.on_all_nodes(forward - back)
    second = response(here, pushed[here.inner] - curved, tolerance=TOLERANCE)
    one, other = (here.mean(here.on_all_nodes(mass) * per_mass) for mass in (middle, second))
    return one, other


def _curvature_of_flow(films: Fields, rise: np.ndarray) -> np.ndarray:
    """Second order of an isothermal film's flow in a change of pressure, on all nodes.

    ½ ∇·Σ c_k H^(3−k) ∇(d²g_k/dP² δP²).
    """
    flux = sum(
        films.gradient(bend * rise**2) * (factor / 2) for factor, _, bend in films.flow_terms
    )
    return films.divergence(np.asarray(flux))

"""The vibration's profile moves along with a surface that slides, past the pad."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from sheared_strip import chebyshev

from squeezefilm.api.film import Film
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import error_budgets
from squeezefilm.quantities.moving_profile import moving_profile_changes
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device

LENGTH_M, H0_M, WAVE_NUMBER = 5e-3, 10e-6, 380.0
VISCOSITY, AMBIENT_PA = 1.81e-5, 101325.0


def marched(
    shape: Callable[[np.ndarray], np.ndarray],
    *,
    sigma: float,
    bearing: float,
    places: np.ndarray,
    moves: np.ndarray,
    epsilon: float = 0.3,
    nodes: int = 20,
    steps: int = 60,
) -> np.ndarray:
    """Mean overpressures of strips when the pads are at their places on the surface, in p0.

    Marched from rest by backward differences of second order. The mean over the period is by
    splines of instants, which see no change with the place below its fourth power.
    """
    x, d_x = chebyshev(nodes)
    weights = np.linalg.inv(d_x[1:, 1:])[-1]
    box = np.ones(steps) / steps
    narrow = np.convolve(box, box)
    wide = np.convolve(narrow, narrow)
    window = -wide
    beside = (len(wide) - len(narrow)) // 2
    window[beside : beside + len(narrow)] += 2 * narrow

    step = 2 * np.pi / steps
    count = steps * (5 + int(1.2 * sigma / (2 * np.pi)))
    middle = (count - (len(window) - 1) // 2) * step
    speed = 2 * bearing / sigma * moves[:, None]
    place = x + places[:, None]
    pressure, means, inner = np.ones_like(place), [], slice(1, -1)
    masses = [np.ones_like(place)] * 2

    def on_diagonal(values: np.ndarray) -> np.ndarray:
        return values[:, :, None] * np.eye(nodes)

    for k in range(1, count + 1):
        time = k * step
        gap = 1 + epsilon * shape(place - speed * (time - middle)) * np.sin(time)
        for _ in range(20):
            slope = pressure @ d_x.T
            rate = (1.5 * gap * pressure - 2 * masses[-1] + 0.5 * masses[-2]) / step
            flux = gap**3 * pressure * slope - bearing * gap * pressure
            rest = flux @ d_x.T - sigma * rate
            flow = (gap**3 * pressure)[:, :, None] * d_x
            flow = flow + on_diagonal(gap**3 * slope - bearing * gap)
            jacobian = d_x @ flow - on_diagonal(1.5 * sigma / step * gap)
            change = np.linalg.solve(jacobian[:, inner, inner], -rest[:, inner, None])[..., 0]
            pressure[:, inner] += change
            if np.abs(change).max() < 1e-10:
                break
        masses = [masses[-1], gap * pressure]
        means.append((pressure - 1)[:, 1:] @ weights)
    return window @ np.array(means[-len(window) :])


def film(*, sigma: float, bearing: float) -> Film:
    """A long pad on a standing wave, so that the film is that of a strip."""
    per_gap = AMBIENT_PA * H0_M**2 / (6 * VISCOSITY * LENGTH_M)
    return Film.of(
        actuator={
            "surface": {"length_x": "500 mm", "length_y": "500 mm"},
            "frequency": sigma * per_gap / (4 * np.pi * LENGTH_M),
            "profile": {"kind": "formula", "expression": f"cos({WAVE_NUMBER}*x)"},
        },
        pad={"length_x": LENGTH_M, "length_y": 40 * LENGTH_M, "speed_x": bearing * per_gap},
        gas={
            "viscosity": VISCOSITY,
            "ambient_pressure": AMBIENT_PA,
            "density": 1e-4,
            "mean_free_path": 1e-12,  # no other effects
            "rarefaction": "none",
            "inertia": "none",
            "thermal": "none",
        },
    )


def scenes_at(places: Sequence[float], *, sigma: float, bearing: float) -> list[Scene]:
    pad = film(sigma=sigma, bearing=bearing)
    return [pad.scene(H0_M, 0.3 * H0_M, x=place * LENGTH_M) for place in places]


def test_the_profiles_motion_is_a_part_of_the_modelling_error():
    """As a strip has it that is marched with a profile that moves."""
    numbers, places = {"sigma": 200.0, "bearing": 0.2}, [0.1, 0.6, -0.6]
    scenes = scenes_at(places, **numbers)
    solutions = solve(scenes, tolerance=1e-3, method="periodic", keep_states=True)
    (found,), (errors,) = moving_profile_changes(scenes, solutions, device=choose_device())
    forces = marched(
        lambda x: np.cos(WAVE_NUMBER * LENGTH_M * (x - 0.5)),
        **numbers,
        places=np.tile(places, 2),
        moves=np.repeat([True, False], len(places)),
    )
    changes = forces[: len(places)] / forces[len(places) :] - 1
    assert np.all(np.abs(found - changes) <= errors + 0.03 * np.abs(changes))
    assert np.all(errors < 0.5 * np.abs(found))
    (budget,) = error_budgets(scenes[:1])
    row = budget.effects["moving_profile"]
    assert row.percent == pytest.approx(100 * changes[0], abs=row.error_percent)
    assert row.error_percent < 0.5 * abs(row.percent)


def test_where_the_pad_passes_the_profile_faster_than_the_film_follows_it_is_unknown():
    (budget,) = error_budgets(scenes_at([0.3], sigma=100.0, bearing=4.0))
    assert "moving_profile" in budget.unknown_effect_names
    assert np.isnan(budget.modelling_error_percent).all()

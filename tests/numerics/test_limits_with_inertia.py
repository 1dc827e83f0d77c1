"""The limits with the gas' inertia: layer, core and second order, against independent solutions.

Strips are by dense collocation, which agrees with a marched, resolved velocity profile; the
square is by a program of the second-order theory.
"""

from collections.abc import Callable

import numpy as np
import pytest

from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.asymptotics.composite import (
    AsymptoticForces,
    composite_expansion,
    edge_layer_expansion,
    high_squeeze_limit,
    small_amplitude_expansion,
)
from squeezefilm.reynolds.asymptotics.edge_layer import EXCURSION_COUNT_WITH_INERTIA
from squeezefilm.reynolds.asymptotics.films import Films, expansion_axis, films_of
from squeezefilm_workflow.verification.edge_layers import (
    layer_rows_with_inertia,
    table_excursions_with_inertia,
    table_reynolds_numbers,
)

SINC_ALONG = 1.098
Method = Callable[[Films], AsymptoticForces]


def at(a: float, reynolds: float) -> list[float]:
    """(ψ² − 1)/a², d/a², g/a and h/a² of the stored table."""
    rise, d, g, h = edge_layer.inertia_layer_functions(np.array([[a]]), np.array([reynolds]))
    scaled = (rise / a**2, d / a**2, g / a, h / a**2)
    return [float(each[0, 0]) for each in scaled]


def sinc(points: tuple[int, int], *, aspect: float = 1.0, along_y: bool = True) -> np.ndarray:
    """The paper's sinc under the centred pad, or one that changes along x alone."""
    x, y = (expansion_axis(count).all_nodes - 0.5 for count in points)
    far = np.hypot(x[:, None], aspect * y * along_y)
    return np.sinc(SINC_ALONG * far)


def on_strip(
    method: Method,
    *,
    epsilon: float,
    sigma: float,
    reynolds: float,
    slip: float = 0.0,
    points: tuple[int, int] = (33, 33),
    side: float = 4.0,
) -> float:
    """Mean under an infinite strip: a pad of twice the length less one of the length."""
    two = np.ones(2)
    profiles = np.repeat(sinc(points, along_y=False)[None], 2, axis=0)
    aspects = np.array([side, 2 * side])
    forces = method(
        films_of(epsilon * two, sigma * two, profiles, aspect=aspects, slip=slip, reynolds=reynolds)
    )
    return float(2 * forces.mean_pressure_ratio[1] - forces.mean_pressure_ratio[0])


def on_square(
    method: Method, *, epsilon: float, sigma: float, reynolds: float, points: int = 47
) -> AsymptoticForces:
    s = sinc((points, points))
    return method(films_of(np.array([epsilon]), np.array([sigma]), s[None], reynolds=reynolds))


@pytest.mark.parametrize("reynolds", [0.0, 0.45, 1.81, 7.0, 10.0])
def test_rim_of_small_excursions(reynolds: float) -> None:
    """(ψ² − 1)/a² → 3/2 + (12/7) r/S − r²/S², r = Re/10, S² = 1 + r²: the linear layer's flux."""
    ratio = reynolds / 10
    root = np.hypot(1, ratio)
    exact = 1.5 + 12 / 7 * ratio / root - (ratio / root) ** 2
    assert at(1e-3, reynolds)[0] == pytest.approx(exact, rel=1e-5)
    if reynolds == 0:
        assert at(1e-3, 0.0)[1:] == pytest.approx(
            [-5 * np.sqrt(2) / 8, 3 / np.sqrt(2), 0], abs=1e-5
        )


@pytest.mark.parametrize(("a", "reynolds"), [(0.4, 0.45), (0.3, 3.3), (0.2, 8.0)])
def test_table_between_its_rows(a: float, reynolds: float) -> None:
    ((_, _, *found),) = layer_rows_with_inertia(reynolds, [a])
    assert at(a, reynolds) == pytest.approx(found, abs=1e-4)
    assert at(a, reynolds)[0] == pytest.approx(found[0], rel=1e-6)


def test_the_layer_of_a_row_of_the_table_is_found_again() -> None:
    """``squeezefilm-verification edge-layers``."""
    table = np.loadtxt(edge_layer.LAYER_TABLE_WITH_INERTIA_PATH, delimiter=",", skiprows=1)
    reynolds = table_reynolds_numbers()[2]
    found = layer_rows_with_inertia(reynolds, table_excursions_with_inertia(reynolds)[:1])
    assert found[0] == pytest.approx(table[2 * EXCURSION_COUNT_WITH_INERTIA], rel=1e-8)


def test_table_says_where_it_ends() -> None:
    values = edge_layer.inertia_layer_functions(
        np.array([[0.41, 0.39], [0.8, 0.91]]), np.array([10.0, 0.0])
    )
    assert np.isnan(values[0]).tolist() == [[True, False], [False, True]]
    assert np.isnan(edge_layer.inertia_layer_functions(np.array([[0.1]]), np.array([10.1]))).all()


@pytest.mark.parametrize(
    ("method", "order", "slack"),
    [(high_squeeze_limit, 0.5, 0.04), (edge_layer_expansion, 1.0, 0.08)],
)
@pytest.mark.parametrize(
    ("epsilon", "reynolds", "exact"),
    [
        (0.4, 0.45, {6400.0: 0.10919474616632582, 102400.0: 0.10867976467036697}),
        (0.2, 1.81, {6400.0: 0.026887240823732773, 102400.0: 0.026758159093579575}),
    ],
)
def test_order_of_the_limits_on_a_strip(
    method: Method,
    order: float,
    slack: float,
    epsilon: float,
    reynolds: float,
    exact: dict[float, float],
) -> None:
    """The fast limit is left by 1/√σ; its layer's correction by 1/σ, where inertia first shows."""
    errors = [
        abs(on_strip(method, epsilon=epsilon, sigma=sigma, reynolds=reynolds) - known)
        for sigma, known in exact.items()
    ]
    assert np.log(errors[0] / errors[1]) / np.log(16) == pytest.approx(order, abs=slack)


@pytest.mark.parametrize(
    ("sigma", "reynolds", "effect"),
    [
        (2331.0, 0.4522, 0.0215),
        (2331 * 25 / 49, 0.8863, 0.0416),
        (582.75, 1.8088, 0.0813),
        (145.69, 7.2352, 0.208),
    ],
)
def test_inertia_at_small_amplitude_on_the_square(
    sigma: float, reynolds: float, effect: float
) -> None:
    """At 5, 7, 10 and 20 µm of the paper's actuator."""
    still, moved = (
        on_square(
            small_amplitude_expansion, epsilon=0.01, sigma=sigma, reynolds=each
        ).mean_pressure_ratio[0]
        for each in (0.0, reynolds)
    )
    assert moved / still - 1 == pytest.approx(effect, abs=6e-5 if effect < 0.1 else 5e-4)


@pytest.mark.parametrize(
    ("epsilon", "sigma", "reynolds", "points", "exact", "product"),
    [
        (0.4, 2331.0, 0.45, (151, 301), 0.10879138236585172, 0.108693826868966),
        (0.2, 583.0, 1.81, (95, 189), 0.02716034693363173, 0.027090759422282683),
    ],
)
def test_slip_and_inertia_together(
    epsilon: float,
    sigma: float,
    reynolds: float,
    points: tuple[int, int],
    exact: float,
    product: float,
) -> None:
    """Better than the product of their effects, which is wrong by a fraction of slip times them."""
    film = {"epsilon": epsilon, "sigma": sigma, "reynolds": reynolds}
    found = on_strip(composite_expansion, **film, slip=0.08, points=points)
    assert found == pytest.approx(exact, rel=1e-3)
    assert abs(found - exact) < 0.5 * abs(product - exact)


@pytest.mark.parametrize(
    ("method", "largest_median"), [(high_squeeze_limit, 4), (edge_layer_expansion, 12)]
)
def test_error_estimates_hold_on_random_films_of_small_amplitude(
    method: Method, largest_median: float
) -> None:
    """Where the second order is exact; off the centre, with up to three nodes of the profile."""
    generator = np.random.default_rng(5)
    ratios = []
    for wave_number in (0.0, 0.5, SINC_ALONG, 1.8, 2.5) * 4:
        sigma, reynolds = 10 ** generator.uniform((1.5, -1.3), (2.8, 0.95))
        (x, y), aspect = generator.uniform(-0.3, 0.3, 2), 10 ** generator.uniform(-0.3, 0.3)
        nodes = expansion_axis(71).all_nodes - 0.5
        s = np.sinc(wave_number * np.hypot(nodes[:, None] - x, aspect * nodes - y))
        film = films_of(
            np.array([0.01]), np.array([sigma]), s[None], aspect=aspect, reynolds=reynolds
        )
        exact, forces = small_amplitude_expansion(film).mean_pressure_ratio[0], method(film)
        ratios.append(forces.pressure_ratio_error[0] / abs(forces.mean_pressure_ratio[0] - exact))
    assert min(ratios) > 1
    # Honest, but not by despair.
    assert np.median(ratios) < largest_median


def test_limits_with_inertia_say_where_they_do_not_hold() -> None:
    film = {"epsilon": 0.3, "sigma": 800.0}
    assert np.isfinite(
        on_square(composite_expansion, **film, reynolds=9.0).pressure_ratio_error
    ).all()
    assert np.isinf(on_square(high_squeeze_limit, **film, reynolds=11.0).pressure_ratio_error).all()
    assert np.isinf(
        on_square(high_squeeze_limit, epsilon=0.9, sigma=800.0, reynolds=8.0).pressure_ratio_error
    ).all()

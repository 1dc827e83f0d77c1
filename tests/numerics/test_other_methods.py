"""The other methods against known forces, against each other, and by order of convergence.

Reference values are those of the film on the unit square under the paper's sinc.
"""

import math
from typing import Any

import numpy as np
import pytest
from physics_facts import ASIDE_N, CENTRED_N

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import solve
from squeezefilm_workflow.verification import chebyshev_march, finite_elements, numpy_periodic
from squeezefilm_workflow.verification.films import film_scene
from squeezefilm_workflow.verification.marching import FloatArray, periods_to_settle

ANDERSON = {"tolerance": 1e-7, "anderson_depth": 10}
SQUEEZE_5UM = 12 * 1.81e-5 * 2 * math.pi * 43_270 * 0.01**2 / (101_325 * 5e-6**2)
NEWTON = 101_325 * 0.01**2  # p0 l0^2


CENTRED = film_scene("", 0.44, SQUEEZE_5UM)
ASIDE = film_scene("", 0.4, SQUEEZE_5UM, x=0.29)


def periodic(scene: Scene, **settings: Any) -> float:
    """The force by the periodic state in NumPy."""
    return numpy_periodic.periodic_mean_force(scene, **settings)


def orders(values: list[float], exact: float) -> FloatArray:
    """Observed orders of convergence of values that each halve the step of the one before."""
    error = np.abs(np.array(values) - exact)
    return np.log2(error[:-1] / error[1:])


# The periodic state in NumPy


@pytest.mark.parametrize(("scene", "newtons"), [(CENTRED, CENTRED_N), (ASIDE, ASIDE_N)])
def test_periodic_force_converges_spectrally_to_the_known_force(scene, newtons):
    errors = [
        abs(periodic(scene, nx=n, ny=n, nt=nt) * NEWTON / newtons - 1)
        for n, nt in ((12, 8), (20, 12), (28, 16))
    ]
    assert errors[1] < errors[0] / 20
    assert errors[2] < 1e-7


# Time marching, at sigma = 20 where a few periods settle the film

SETTLED = periods_to_settle(sigma=20, tolerance=1e-9)
SCENE = film_scene("", 0.4, 20.0)


@pytest.fixture(scope="module")
def converged():
    return periodic(SCENE, nx=32, ny=32, nt=32, tolerance=1e-12)


def elements(scene: Scene = SCENE, **given: Any) -> float:
    settings = {"cells": 4, "steps": 64, "periods": SETTLED} | given
    return finite_elements.periodic_mean_force(scene, **settings)


def chebyshev(**settings: Any) -> float:
    return chebyshev_march.periodic_mean_force(SCENE, **settings)


def test_crank_nicolson_is_of_second_order_in_time(converged):
    found = [elements(cells=6, steps=steps) for steps in (16, 32, 64)]
    assert orders(found, converged) == pytest.approx(2, abs=0.2)


def test_biquadratic_elements_are_of_fourth_order_in_space():
    fine = elements(cells=12, steps=16)
    found = [elements(cells=cells, steps=16) for cells in (2, 4)]
    assert orders(found, fine)[0] > 3.2


def test_chebyshev_march_converges_spectrally(converged):
    errors = [abs(chebyshev(points=points, rtol=1e-8) - converged) for points in (3, 6, 9)]
    assert errors[1] < errors[0] / 50
    assert errors[2] < 1e-7 * converged


def test_finite_elements_agree_on_the_bearing_term():
    sliding = film_scene("", 0.4, 200.0, 20.0)
    exact = periodic(sliding, nx=32)
    settings = {"cells": 6, "periods": 40} | ANDERSON
    coarse, fine = (elements(sliding, **settings, steps=n) for n in (32, 64))
    assert (4 * fine - coarse) / 3 == pytest.approx(exact, rel=1e-4)
    assert exact < 0.98 * periodic(film_scene("", 0.4, 200.0))


# The force of the paper's largest extrapolation, by two other methods


def test_finite_elements_give_the_known_force():
    """Anderson's mixing takes a tenth of the periods."""
    found = elements(CENTRED, **{"cells": 6, "steps": 32, "periods": 20} | ANDERSON)
    assert found * NEWTON == pytest.approx(CENTRED_N, rel=2e-5)


def test_marching_gives_the_periodic_solver_s_force():
    """F(5 µm, 2.2 µm) to the digits that README promises."""
    (solution,) = solve([CENTRED], tolerance=1e-8)
    marched = chebyshev_march.periodic_mean_force(CENTRED, points=14, rtol=1e-8)
    assert marched == pytest.approx(solution.force_n / CENTRED.force_scale_n, rel=4e-8)

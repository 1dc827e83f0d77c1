"""A fitted model's error is measured on a sample that no fit uses, and stated as what it is."""

import numpy as np
import pytest
from scipy import stats

from squeezefilm.columns import COLUMNS
from squeezefilm.models.data import Factors
from squeezefilm.models.prediction_interval import (
    PredictionInterval,
    conformal_interval,
    ranking_points_mask,
)

RANGES = {"h0_m": (5e-6, 10e-6), "hv_m": (0.2e-6, 2e-6), "phi_r_m": (0.0, 2e-3)}
RANGES["phi_deg"] = (0.0, 45.0)


def drawn(count: int, *, seed: int) -> Factors:
    """Independent points, uniform over RANGES."""
    random = np.random.default_rng(seed)
    return Factors.of(**{name: random.uniform(*limits, count) for name, limits in RANGES.items()})


def truth_n(factors: Factors) -> np.ndarray:
    return 5 * factors.epsilon**2


def model_n(factors: Factors) -> np.ndarray:
    """Off by up to 3 %, and by a wave over the position that no plan needs to see."""
    return truth_n(factors) * (1 + 0.03 * np.sin(5e3 * factors.phi_r_m) * factors.epsilon)


def interval(factors: Factors, **changes) -> PredictionInterval:
    force = truth_n(factors)
    given = {
        "model_n": model_n(factors),
        "force_n": force,
        "force_error_n": 1e-6 * force,
        "scale": (1e-4, 0.01),
        "ranges": RANGES,
    }
    return conformal_interval(factors, **given | changes)


def share_inside(measured: PredictionInterval, factors: Factors, level: float = 0.95) -> float:
    modelled = model_n(factors)
    error = np.abs(modelled - truth_n(factors))
    return float(np.mean(error <= measured.error_n(modelled, level=level)))


def test_of_new_points_as_many_are_inside_as_stated():
    """Over samples the share inside is beta-binomial, and on average k/(n + 1)."""
    calibration, fresh, repeats = 100, 500, 60
    for level, rank in ((0.95, 96), (0.99, 100)):
        inside = [
            share_inside(
                interval(drawn(2 * calibration, seed=seed)), drawn(fresh, seed=10**6 + seed), level
            )
            for seed in range(repeats)
        ]
        law = stats.betabinom(fresh, rank, calibration + 1 - rank)
        mean, deviation = law.mean() / fresh, law.std() / fresh
        assert abs(np.mean(inside) - mean) < 4 * deviation / np.sqrt(repeats)
        assert min(inside) >= law.ppf(1e-3 / repeats) / fresh


def test_a_simulation_without_a_force_counts_as_infinitely_wrong():
    factors = drawn(200, seed=1)
    force, calibration = truth_n(factors), np.flatnonzero(~ranking_points_mask(200))
    few, many = force.copy(), force.copy()
    few[calibration[:4]], many[calibration[:5]] = np.nan, np.nan
    assert interval(factors, force_n=few).failed == 4
    assert interval(factors, force_n=few).error_95[1] > interval(factors).error_95[1]
    assert interval(factors, force_n=few).error_99 is None
    lost = interval(factors, force_n=many)
    assert lost.error_95 is None
    half = f"as measured on {len(calibration)} of 200 independent simulations; "
    assert half in interval(factors).statement
    assert lost.statement.startswith("Not validated: of 200 independent simulations, 5 of which")
    assert np.isnan(lost.error_n([0.5])).all()


def test_the_simulations_own_error_and_the_scans_are_in_the_interval():
    factors = drawn(400, seed=1)
    plain = interval(factors)
    loose = interval(factors, force_error_n=0.02 * truth_n(factors))
    assert loose.error_n([1.0])[0] >= plain.error_n([1.0])[0] + 0.015
    scanned = interval(factors, profile_uncertainty=0.03)
    assert scanned.error_n([1.0]) == pytest.approx(plain.error_n([1.0]) + 0.03)
    wide = scanned.error_n([1.0], level=0.99) - plain.error_n([1.0], level=0.99)
    assert wide == pytest.approx(0.03 * 2.5758 / 1.96, rel=1e-4)


def test_coverage_is_shown_by_region():
    """Where a model is worst fewer points are inside than on average, and the table shows it."""
    factors = drawn(2000, seed=3)
    worse = truth_n(factors) * (1 + 0.02 * (factors.phi_r_m > 1.5e-3))
    found = interval(factors, model_n=worse * (1 + 1e-3 * factors.epsilon), scale=(0.0, 1.0))
    shares = {(r["quantity"], r["third"]): r["coverage"] for r in found.coverage}
    assert found.mean_coverage == pytest.approx(0.95, abs=0.03)
    assert shares["phi_r_m", "high"] < found.mean_coverage < shares["phi_r_m", "low"] == 1
    # The points of the region have it in a note, and no others.
    region = f"high third of the {COLUMNS['phi_r_m'].label}"
    noted = np.array([region in note for note in found.coverage_notes(factors)])
    assert shares["phi_r_m", "high"] < 0.9
    assert noted.mean() == pytest.approx(1 / 3, abs=0.02)
    assert factors.phi_r_m[noted].min() > factors.phi_r_m[~noted].max()
    assert {"h0_m", "hv_m", "epsilon", "phi_r_m", "phi_deg"} == {name for name, _ in shares}


@pytest.mark.parametrize(
    ("point", "note"),
    [
        ({}, ""),
        ({"h0_m": 4.9e-6}, "h0 = 4.9 µm outside 5 … 10 µm"),
        ({"phi_r_m": 1e-3, "phi_deg": 50.0}, "φ = 50 ° outside"),
        ({"phi_r_m": 0.0, "phi_deg": 50.0}, ""),
    ],
)
def test_outside_the_declared_space_a_fit_is_not_validated(point, note):
    found = interval(drawn(100, seed=1))
    (outside,) = found.range_notes(Factors.of(**{"h0_m": 6e-6, "hv_m": 1e-6} | point))
    assert (note in outside) if note else outside == ""


def test_the_space_is_in_the_symbols_of_formulas():
    """A direction is φ and a distance r, as in the nomenclature; not the paper's φφ and φr."""
    found = interval(drawn(200, seed=1))
    read = found.model_copy(update={"ranges": dict(sorted(found.ranges.items()))})
    for space in (found.space_name, read.space_name):
        assert space == "h0 5 to 10 µm, hv 0.2 to 2 µm, r 0 to 2 mm, φ 0 to 45 °"

"""A fitted model's error is measured on a sample that no fit uses, and stated as what it is."""

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from scipy import stats

from squeezefilm.cli import main as cli
from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import fit_of
from squeezefilm.models.force_model import get_model
from squeezefilm.models.prediction_interval import (
    PredictionInterval,
    error_scale,
    measured_interval,
    ranking_half,
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
    return measured_interval(factors, **given | changes)


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
    force, calibration = truth_n(factors), np.flatnonzero(~ranking_half(200))
    few, many = force.copy(), force.copy()
    few[calibration[:4]], many[calibration[:5]] = np.nan, np.nan
    assert interval(factors, force_n=few).failed == 4
    assert interval(factors, force_n=few).error_95[1] > interval(factors).error_95[1]
    assert interval(factors, force_n=few).error_99 is None
    lost = interval(factors, force_n=many)
    assert lost.error_95 is None
    assert lost.statement.startswith("Not validated: of 200 independent simulations, 5 of which")
    assert np.isnan(lost.error_n([0.5])).all()


def test_too_few_simulations_give_no_interval():
    assert interval(drawn(38, seed=1)).error_95 is not None
    assert interval(drawn(36, seed=1)).error_95 is None
    assert interval(drawn(198, seed=1)).error_99 is not None
    assert interval(drawn(196, seed=1)).error_99 is None


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
    assert {"h0_m", "hv_m", "epsilon", "phi_r_m", "phi_deg"} == {name for name, _ in shares}


def test_the_scale_follows_the_residuals():
    force = np.linspace(0.01, 1, 50)
    assert error_scale(0.02 * force, force) == pytest.approx((1e-3 * 0.02 * force.mean(), 0.02))
    constant, share = error_scale(1e-3 + 0.02 * force, force)
    assert (constant, share) == pytest.approx((1e-3, 0.02))
    untold = error_scale(np.full(50, np.nan), force)
    assert untold == pytest.approx((0.1 * force.mean(), 1.0))


@pytest.mark.parametrize(
    ("point", "note"),
    [
        ({}, ""),
        ({"h0_m": 5e-6 * (1 - 1e-12)}, ""),
        ({"h0_m": 4.9e-6}, "h0_m outside 5e-06 … 1e-05"),
        ({"hv_m": 2.1e-6}, "hv_m outside"),
        ({"phi_r_m": 2.1e-3}, "phi_r_m outside"),
        ({"phi_r_m": 1e-3, "phi_deg": 50.0}, "phi_deg outside"),
        ({"phi_r_m": 0.0, "phi_deg": 50.0}, ""),
    ],
)
def test_outside_the_declared_space_a_fit_is_not_validated(point, note):
    found = interval(drawn(100, seed=1))
    (outside,) = found.outside(Factors.of(**{"h0_m": 6e-6, "hv_m": 1e-6} | point))
    assert (note in outside) if note else outside == ""


def test_an_interval_is_what_its_file_holds():
    found = interval(drawn(100, seed=1), profile_uncertainty=0.01)
    assert PredictionInterval.model_validate_json(found.model_dump_json()) == found
    lost = found.model_copy(update={"error_95": None})
    assert PredictionInterval.model_validate_json(lost.model_dump_json()) == lost
    with pytest.raises(ValidationError, match="ranges must be of h0_m"):
        PredictionInterval.model_validate(found.model_dump() | {"ranges": {"evil": (0, 1)}})


def test_a_model_whose_table_of_physics_is_too_coarse_is_not_offered(limit_fit):
    """Disc of 20 mm radius, 700 rad/m: the table erred by 0.47 of the force, and nobody read it."""
    fit, factors, force_n = limit_fit
    validated = fit.validated(factors, force_n=force_n, force_error_n=0 * force_n, ranges=RANGES)
    assert validated.interval is not None
    values = fit.to_dict()
    table = values["limit_table"]
    coefficients = table["coefficients"]
    wrong = [value * (1 + 1e-3 * (-1) ** k) for k, value in enumerate(coefficients["limit_n"])]
    coarse = table | {"coefficients": coefficients | {"limit_n": wrong}}
    fit = fit_of({**values, "limit_table": coarse}, place="here")
    with pytest.raises(InputError, match="table of asymptotic forces is too coarse"):
        fit.validated(factors, force_n=force_n, force_error_n=0 * force_n, ranges=RANGES)


@pytest.fixture(scope="module")
def limit_fit(repository):
    """A fit of `limit_1` whose own error is 1e-5 of the force, with a sample."""
    from squeezefilm.config.loading import load_config
    from squeezefilm.models.limit_table import LimitTable
    from squeezefilm.studies.tasks.physics_limits import limit_table_of

    table = limit_table_of(load_config(repository / "config" / "quick.yaml"))
    model, factors = get_model("limit_1"), drawn(200, seed=4)
    assert isinstance(table, LimitTable)
    known = table.complete(factors)
    values = {
        "model": "limit_1",
        "theta": [0.0],
        "points": 60,
        "global_error": 1e-5,
        "sum_of_squares": 1e-5,
        "error_scale": [0.0, 1e-5],
        "limit_table": table,
    }
    force_n = model.evaluate([0.0], known) * (1 + 1e-5 * np.sin(1e7 * factors.h0_m))
    return fit_of(values, place="test"), known, force_n


def test_a_fit_to_a_table_of_ones_own_is_not_validated(study, tmp_path):
    """Without a validation sample nothing is claimed; with one the file carries its interval."""
    forces = study.root / "simulations" / "screen" / "forces.csv"
    common = ["fit", str(forces), "--model=two_factor", f"--config={study.config}", "--seeds=1"]

    def predicted(*words: str) -> pd.Series:
        fit, out = tmp_path / "fit.json", tmp_path / "out.csv"
        assert cli.main([*common, *words, f"--output={fit}"]) == 0
        point = ["--h0=5um", "--hv=2um", f"--output={out}"]
        assert cli.main(["predict", str(fit), *point]) == 0
        return pd.read_csv(out).iloc[0]

    bare = predicted()
    assert np.isnan(bare["error_95_n"])
    assert bare["note"].startswith("not validated: the fit has no validation sample")
    sampled = predicted(f"--sample={forces}")
    assert 0 < sampled["error_95_n"] < sampled["error_99_n"] or np.isnan(sampled["error_99_n"])
    assert pd.isna(sampled["note"])

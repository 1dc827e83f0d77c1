"""A point is trusted on the evidence of simulations that the fit never saw, and never else."""

import json
import shutil
import subprocess
from copy import deepcopy
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from squeezefilm.cli import main as cli
from squeezefilm.io.positions import CARTESIAN, POLAR
from squeezefilm.io.tables import FACTOR_COLUMNS, scene_points
from squeezefilm.models.cross_validation import film_folds, left_out_predictions
from squeezefilm.models.description import describe
from squeezefilm.models.fitting.local_fit import local_fit
from squeezefilm.models.force_model import Factors, get_model
from squeezefilm.models.trust import LEAST_POINTS, MOST_RELATIVE_ERROR, Trust, Unseen
from squeezefilm.reynolds import solve
from squeezefilm.studies.config import Config
from squeezefilm.studies.plans import centred_grid, level_values, plan, random_plan
from squeezefilm.studies.study import scene_of

TOLERANCE = 1e-4
START = {"two_factor": (7.0, 1.0, -1.0), "four_factor": (7.0, 1.0, -1.0, 0.01, -50.0)}
STUDIES: dict[str, dict[str, dict[str, Any]]] = {
    "the paper's": {},
    "wide gaps": {
        "screen": {
            "h0_m": {"start": 15e-6, "stop": 30e-6, "levels": 6},
            "hv_m": {"start": 0.5e-6, "stop": 6e-6, "levels": 8},
        },
    },
    "another pad and profile": {
        "screen": {
            "h0_m": {"start": 8e-6, "stop": 16e-6, "levels": 6},
            "hv_m": {"start": 0.5e-6, "stop": 6e-6, "levels": 8},
        },
        "finger": {"length_x_m": 0.013, "length_y_m": 0.009},
        "actuator": {"profile": {"kind": "sinc", "wave_number_per_m": 150}},
    },
}
REACH_M = 0.0018


def changed(config: Config, changes: dict[str, dict[str, Any]]) -> Config:
    sections = deepcopy(config.sections)
    return Config(config.path, sections | {k: sections[k] | v for k, v in changes.items()})


def simulated(config: Config, table: pd.DataFrame) -> tuple[Factors, np.ndarray, np.ndarray]:
    points = table[list(FACTOR_COLUMNS)].to_numpy()
    first, *rest = scene_points(table)
    scene = scene_of(first, config)
    scenes = [scene, *(replace(scene, **vars(each)) for each in rest)]
    found = solve(scenes, tolerance=TOLERANCE)
    assert all(each.status == "ok" for each in found)
    force, error = ([getattr(s, name) for s in found] for name in ("force_n", "force_error_n"))
    return Factors.of(**dict(zip(FACTOR_COLUMNS, points.T, strict=True))), force, error


def box(config: Config, *, reach_m: float, beyond: float) -> dict[str, tuple[float, float]]:
    """The study's space, stretched by a share on either side."""
    ranges = {
        name: (config["screen"][name]["start"], config["screen"][name]["stop"])
        for name in ("h0_m", "hv_m")
    }
    ranges |= {"phi_r_m": (0.0, reach_m), "phi_deg": (0.0, 45.0)}
    return {
        n: (low - beyond * (high - low) * (low > 0), high + beyond * (high - low))
        for n, (low, high) in ranges.items()
    }


def fitted(config: Config, kind: str) -> tuple[str, np.ndarray, Trust, float]:
    """A fit of one kind, with its evidence: model, parameters, trust, farthest finger position."""
    screen, space = config["screen"], box(config, reach_m=REACH_M, beyond=0.0)
    centre = space | {"phi_r_m": (0.0, 0.0), "phi_deg": (0.0, 0.0)}
    grid = centred_grid(h0_m=level_values(screen["h0_m"]), hv_m=level_values(screen["hv_m"]))
    (low, high), (least, most) = space["h0_m"], space["hv_m"]
    if kind.startswith("screen"):
        model, table, control, reach = "two_factor", grid, None, 0.0
    elif kind == "five points":
        pairs = np.array(
            [
                (low, most),
                (0.6 * low + 0.4 * high, most),
                (high, least),
                (low, 0.7 * most),
                (low, least),
            ]
        )
        model, reach, table = "two_factor", 0.0, plan(h0_m=pairs[:, 0], hv_m=pairs[:, 1])
        control = random_plan(points=30, seed=4, **centre)
    else:
        model, reach = "four_factor", REACH_M
        table = random_plan(points=40, seed=5, **space)
        corners = [
            plan(h0_m=[low, high], hv_m=[most, least], phi_r_m=r, phi_deg=a)
            for r, a in ((0.0, 0.0), (reach, 0.0), (reach, 45.0))
        ]
        table = pd.concat([*corners, table], ignore_index=True)
        control = random_plan(points=60, seed=6, **space)
    factors, force, error = simulated(config, table)
    theta = local_fit(get_model(model), factors, force, start=START[model])
    unseen = Unseen.of(
        factors,
        model_n=left_out_predictions(
            get_model(model), factors, force, theta=theta, folds=5, seed=1
        ),
        force_n=force,
        force_error_n=error,
    )
    trust = Trust.of(factors, unseen)
    if control is not None:
        factors, force, error = simulated(config, control)
        own = get_model(model).evaluate(theta, factors)
        trust = trust.with_control(
            Unseen.of(factors, model_n=own, force_n=force, force_error_n=error)
        )
    return model, theta, trust, reach


@pytest.mark.parametrize("kind", ["screen, points left out", "five points", "finger anywhere"])
@pytest.mark.parametrize("name", STUDIES)
def test_at_trusted_points_the_simulation_lies_within_the_band(name, kind, paper):
    config = changed(paper, STUDIES[name])
    model, theta, trust, reach = fitted(config, kind)
    table = random_plan(points=24_000, seed=9, **box(config, reach_m=reach, beyond=0.2))
    table = table[table["hv_m"] < 0.9 * table["h0_m"]]
    factors = Factors.of(**{each: table[each] for each in FACTOR_COLUMNS})
    force = get_model(model).evaluate(theta, factors)
    verdict = trust.judge(factors, force)
    chosen = np.flatnonzero(verdict.trusted)[:1000]
    assert len(chosen) == 1000
    assert len(chosen) < len(table)
    _, simulation, error = simulated(config, table.iloc[chosen])
    off = np.abs(force[chosen] - simulation)
    inside = off <= verdict.error_n[chosen] + error
    assert np.mean(inside) >= 0.99
    assert np.all(verdict.error_n[chosen] <= MOST_RELATIVE_ERROR * np.abs(force[chosen]))


def in_x_and_y(factors: Factors) -> Factors:
    names = ("h0_m", "hv_m", *CARTESIAN)
    return Factors.of(**{name: factors.column(name) for name in names})


@pytest.mark.parametrize("form", [POLAR, CARTESIAN])
def test_the_page_computes_the_same(repository, paper, form):
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node here")
    model, theta, trust, _ = fitted(paper, "finger anywhere")
    trust = replace(trust, scan_error=0.01)
    ranges = {"h0_m": (4e-6, 11e-6), "hv_m": (0.1e-6, 2.2e-6)}
    table = random_plan(points=300, seed=3, **ranges, phi_r_m=(0, 2e-3), phi_deg=(0, 50))
    table.loc[:50, "phi_r_m"] = 0.0
    factors = Factors.of(**{each: table[each] for each in FACTOR_COLUMNS})
    if form == CARTESIAN:
        own, seen = (in_x_and_y(each) for each in (trust.fitted, trust.unseen.factors))
        trust, factors = replace(trust, fitted=own), in_x_and_y(factors)
        trust = replace(trust, unseen=replace(trust.unseen, factors=seen))
    force = get_model(model).evaluate(theta, factors)
    names = ("h0_m", "hv_m", *form)
    points = pd.DataFrame({name: factors.column(name) for name in names}).to_dict("records")
    scripts = "".join(
        (repository / "workflow/reporting/explorer" / name).read_text(encoding="utf-8")
        for name in ("model.js", "trust.js")
    )
    program = (
        f"{scripts}; const given = JSON.parse(require('fs').readFileSync(0, 'utf8'));"
        "const unseen = unseenOf(given.trust);"
        "console.log(JSON.stringify(given.points.map(completed).map((point, index) => {"
        "  const value = given.force_n[index];"
        "  const found = judge(given.trust, unseen, point, value, given.most);"
        "  return [value, found.error_n, found.distance, found.trusted, found.outside.length];"
        "})));"
    )
    given = {"trust": trust.to_dict(), "points": points, "force_n": force.tolist()}
    told = subprocess.run(
        [node, "-e", program],
        input=json.dumps(given | {"most": MOST_RELATIVE_ERROR}),
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    ).stdout
    found = np.array(json.loads(told), dtype=float)
    verdict = trust.judge(factors, force)
    expected = np.column_stack([force, verdict.error_n, verdict.distance])
    np.testing.assert_allclose(found[:, :3], expected, rtol=1e-10)
    np.testing.assert_array_equal(found[:, 3] == 1, verdict.trusted)
    np.testing.assert_array_equal(found[:, 4] > 0, [bool(each) for each in trust.outside(factors)])
    assert 20 < np.sum(verdict.trusted) < 280


def evidence(count: int, *, error_n: float = 1e-3) -> tuple[Factors, Unseen]:
    """A fit to a grid and simulations between its points, all off by as much."""
    grid = centred_grid(h0_m=np.linspace(5e-6, 10e-6, 3), hv_m=np.linspace(0.2e-6, 2e-6, 3))
    points = random_plan(
        points=count, seed=1, h0_m=(5e-6, 10e-6), hv_m=(1e-6, 2e-6), phi_r_m=(0, 0), phi_deg=(0, 0)
    )
    factors, between = (Factors.of(h0_m=t["h0_m"], hv_m=t["hv_m"]) for t in (grid, points))
    force = 5 * between.epsilon**2
    unseen = Unseen.of(between, model_n=force + error_n, force_n=force, force_error_n=1e-4 * force)
    return factors, unseen


AT = Factors.of(h0_m=6e-6, hv_m=1.5e-6)


def test_a_few_unseen_simulations_are_not_enough():
    few, enough = (
        Trust.of(*evidence(count)).judge(AT, [0.3]) for count in (LEAST_POINTS - 1, LEAST_POINTS)
    )
    assert [*few.trusted, *enough.trusted] == [False, True]
    # The error of the simulations is in the band.
    assert enough.error_n[0] >= 1e-3 + 1e-4 * 0.3 * (1 - 1e-9)


def test_a_fitted_point_is_no_evidence():
    """A model that is exact at its points is not trusted for that, not even there."""
    factors, _ = evidence(LEAST_POINTS)
    force = 5 * factors.epsilon**2
    exact = Unseen.of(factors, model_n=force, force_n=force, force_error_n=0 * force)
    verdict = Trust.of(factors, None).with_control(exact).judge(factors, force)
    assert not verdict.trusted.any()
    assert all("judged by 0 simulations that the fit never saw" in r for r in verdict.reasons)


def test_what_the_scan_leaves_open_is_in_the_band():
    """No simulation shows it, neither a point left out nor a control point."""
    factors, unseen = evidence(100)
    (without,), (within,) = (
        Trust.of(factors, unseen, scan_error=share).with_control(unseen).judge(AT, [0.3]).error_n
        for share in (0.0, 0.05)
    )
    assert within == pytest.approx(without + 0.05 * 0.3)
    (reason,) = Trust.of(factors, unseen, scan_error=0.2).judge(AT, [0.3]).reasons
    assert "20 % of it by the scan" in reason


@pytest.mark.parametrize(
    ("point", "reason"),
    [
        ((4e-6, 1e-6, 0.0), "h0_m outside 5e-06"),
        ((6e-6, 2.1e-6, 0.0), "hv_m outside 2e-07"),
        ((6e-6, 1e-6, 1e-3), "phi_r_m outside 0 … 0"),
        ((6e-6, 1.5e-6, 0.0), ""),
    ],
)
def test_outside_its_ranges_a_fit_is_not_trusted(point, reason):
    factors, unseen = evidence(40)
    at = Factors.of(h0_m=point[0], hv_m=point[1], phi_r_m=point[2], phi_deg=0.0)
    verdict = Trust.of(factors, unseen).judge(at, [0.3])
    assert reason in verdict.reasons[0]
    assert verdict.trusted[0] == (not reason)
    # (7, 6) µm lies in neither point's reach where only (7, 2) and (10, 6) µm were fitted.
    factors = Factors.of(h0_m=[7e-6, 10e-6, 7e-6], hv_m=[2e-6, 6e-6, 1e-6])
    outside = Trust.of(factors, None).outside(Factors.of(h0_m=7e-6, hv_m=6e-6))
    assert outside == ["hv_m/h0_m outside 0.1429 … 0.6"]


def test_far_from_every_unseen_simulation_the_reason_is_the_distance():
    factors, unseen = evidence(40)
    slope = replace(unseen, error_n=0.05 * (unseen.factors.hv_m / 1e-6 - 1))
    verdict = Trust.of(factors, slope).judge(Factors.of(h0_m=9e-6, hv_m=0.3e-6), [0.005])
    assert "may be off by" in verdict.reasons[0]
    assert "of its ranges away" in verdict.reasons[0]
    assert verdict.distance[0] > 0.3


def test_control_points_make_five_fitted_points_trusted(study, tmp_path):
    fit = f"{study.root}/fits/two_factor_design.json"

    def row(command: str, *words: str) -> pd.Series:
        assert cli.main([command, fit, *words, f"--output={tmp_path}/out.csv"]) == 0
        return pd.read_csv(tmp_path / "out.csv").iloc[0]

    point = ("predict", "--h0=7um", "--hv=1.5um")
    alone = row(*point)
    assert np.isnan(alone["within_percent"])
    assert "--control" in alone["note"]
    control = f"--control={study.root}/simulations/screen/forces.csv"
    for words in (point, ("working-point", "--force=0.3N", "--h0=6um")):
        assert 0 < row(*words, control)["within_percent"] < 15


def test_copies_of_fitted_points_are_no_evidence():
    """Under a travelling wave the force does not depend on the place: 25 places are one point."""
    films = centred_grid(h0_m=[6e-6, 14e-6], hv_m=[0.5e-6, 3e-6])
    places = [(r, angle) for r in (1e-3, 2e-3, 3e-3, 4e-3, 5e-3) for angle in range(0, 50, 10)]
    table = pd.concat([films.assign(phi_r_m=r, phi_deg=a) for r, a in places], ignore_index=True)
    factors = Factors.of(**{each: table[each] for each in FACTOR_COLUMNS})
    force = np.sqrt(factors.h0_m / 1e-5) * factors.epsilon**2
    model = get_model("polynomial_3")
    fit = SimpleNamespace(theta=local_fit(model, factors, force, np.zeros(3)))
    said = describe(model, factors, force, fit, force_error_n=0 * force, scan_error=0.0)
    folds = film_folds(factors, folds=5, seed=1)
    assert len(np.unique(folds)) == 4 == said["cross_validation"]["folds"]
    assert all(len(np.unique(folds[k::4])) == 1 for k in range(4))
    own = np.abs(model.evaluate(fit.theta, factors) - force)
    assert said["cross_validation"]["largest_n"] > 3 * own.max()


def test_no_less_is_claimed_of_a_fitted_point_than_its_residual():
    """A point left out may lie nearer to the fit of the others than to the fit of all."""
    model = get_model("polynomial_3")
    films = centred_grid(h0_m=np.linspace(12e-6, 50e-6, 6), hv_m=np.linspace(1e-6, 10e-6, 6))
    factors = Factors.of(**{each: films[each] for each in ("h0_m", "hv_m")})
    force = 15 * factors.epsilon**2 * (1 + 0.5 * np.exp(-(((factors.h0_m - 3e-5) / 1e-5) ** 2)))
    theta = local_fit(model, factors, force, (15.0, 5.0, 20.0))
    fit = SimpleNamespace(theta=theta)
    told = describe(model, factors, force, fit, force_error_n=0 * force, scan_error=0.0)
    fitted = model.evaluate(theta, factors)
    claimed = Trust.from_dict(told["trust"], place="fit").judge(factors, fitted).error_n
    assert (claimed >= np.abs(fitted - force) * (1 - 1e-9)).all()

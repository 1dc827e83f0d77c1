"""Measured forces beside computed ones: by hand, of the synthetic example, and of wrong tables."""

import pandas as pd
import pytest
from example_measurements import synthetic_forces

from squeezefilm.api.measurements import PARTS, compare_measurements, summary_of, with_residuals
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.quantities.derivatives import with_derivatives
from squeezefilm.reynolds import solve
from squeezefilm.studies.study import check_study, scene_of

NAN, STUDY = float("nan"), "config/synthetic.yaml"
HEAD, ROW = "h0 [µm],hv [µm],force [mN],force uncertainty [mN]", "\n5,1,10,1"
WORTH = [
    ([10.5, 11, 9], [0, 0, 0], 2.25, 2.25, "at 3 of 4 points are within measurement uncertainty"),
    ([13, 12, 10], [2, 2, 2], 13, 1, "the modelling error can explain them"),
    ([13, 12, 10], [1, 2, NAN], 13, None, "the modelling error is not known at 1 of them"),
    ([15, 10, 10], [1, 2, NAN], 25, None, "by more than 2 uncertainties at a"),
    ([7, 10, 10], [2, 2, 2], 9, 9, "by more than 2 uncertainties at a"),
]
WRONG = {
    "": "measured.csv: the table is empty; it needs h0 [µm], hv [µm], force [mN]",
    HEAD: "a header and no rows",
    HEAD + "\n5,1,10,": "line 2: force_uncertainty_n is ''",
    HEAD + ROW + "\n5,1,10,0": "line 3: force_uncertainty_n is 0; it must be above 0",
    HEAD.replace("mN", "kg") + ROW: "column 'force_n' is missing; it has h0_m, hv_m, force [kg]",
    "h0,hv,force" + ROW: "line 2: 4 cells",
    HEAD + ",h0 uncertainty [nm]\n5,4,1,1,1e3": "point line 2 with its uncertainties: hv_m = 4e-06",
    HEAD + ",colour" + ROW + ",red": "unknown column 'colour'",
}


@pytest.mark.parametrize(("measured", "upper", "squares", "beyond", "worth"), WORTH)
def test_chi_square_is_that_found_by_hand(measured, upper, squares, beyond, worth):
    """Three points of 10 N, each with the uncertainty 1 = √(0.6² + 0.8²), and one without a force."""
    table = pd.DataFrame(
        {"measured_force_n": [*measured, 1], "modelling_error_upper_n": [*upper, 0]}
    )
    table = table.assign(point_id=[*"abcd"], status=["ok"] * 3 + ["not converged"], force_n=10.0)
    table[["force_error_n", "profile_uncertainty_n", "modelling_error_lower_n"]] = 0.0
    found = summary_of(with_residuals(table.assign(**dict(zip(PARTS, (0.6, 0.8, 0.0))))))
    assert [found["chi_square"], found["chi_square_unexplained"]] == pytest.approx(
        [squares, beyond]
    )
    assert worth in found["verdict"]


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_table_is_refused_before_anything_runs(text, repository, tmp_path):
    study = (
        (repository / STUDY).read_text(encoding="utf-8").replace("synthetic.csv", "measured.csv")
    )
    (tmp_path / "study.yaml").write_text(study, encoding="utf-8")
    (tmp_path / "measured.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        check_study(load_config(tmp_path / "study.yaml"))
    assert WRONG[text] in str(refusal.value)


def test_the_synthetic_forces_are_explained_by_inertia(repository):
    path = repository / STUDY
    made, config = synthetic_forces(path.read_text(encoding="utf-8"), path), load_config(path)
    pd.testing.assert_frame_equal(
        made, pd.read_csv(path.with_suffix(".csv")), check_dtype=False, atol=0.011
    )
    table = compare_measurements(config)
    assert "the modelling error can explain them" in summary_of(table)["verdict"]
    scene = scene_of(config, *table.loc[11, ["h0_m", "hv_m"]])
    (solution,) = with_derivatives(
        [scene], solve([scene], tolerance=1e-5, keep_states=True), tolerance=1e-5
    )
    for name, part in zip(("h0", "hv"), PARTS[1:]):
        by_adjoint = (
            abs(solution.derivatives.value[f"{name}_m"]) * table.loc[11, f"{name}_uncertainty_m"]
        )
        assert table.loc[11, part] == pytest.approx(by_adjoint, rel=2e-3)

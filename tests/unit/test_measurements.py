"""Measured forces beside computed ones: by hand, of the synthetic example, and of wrong tables."""

import pandas as pd
import pytest
from example_measurements import synthetic_forces

from squeezefilm.api.measurements import (
    FORCE_UNCERTAINTY_COLUMNS,
    chi_square_summary,
    compare_measurements,
    with_residuals,
)
from squeezefilm.config.loading import load_config
from squeezefilm.tables import read_measurements

# Forces, bounds of the modelling error, χ² by itself and beyond the bounds, the verdict.
WORTH = [
    (
        [10.5, 11, 9, 1],
        [0, 0, None, 0],
        2.25,
        None,
        "(3 of 4 points), differences are within measurement",
    ),
    ([13, 12, 10, 1], [2, 2, 2, 0], 13, 1, "the modelling error can explain them"),
    ([13, 12, 10, 1], [1, 2, None, 0], 13, None, "the modelling error is not known at 1 of them"),
    ([7, 10, 15, 1], [2, 2, 1, 0], 34, 25, "and the known errors of the computed forces"),
]
GERMAN = "Spalt h0 [µm];Amplitude [µm];Kraft F [mN];Unsicherheit Kraft [mN]\n5,0;1,0;9,5;2,0"
HEAD, ROW = "h0 [µm],hv [µm],force [mN],force uncertainty [mN]", "\n5,1,10,1"
WRONG = {
    "": "measured.csv: the table is empty; it needs h0 [µm], hv [µm], force [mN]",
    HEAD + "\n5,1,10,": "line 2: force uncertainty [mN] is ''",
    HEAD + ROW + "\n5,1,10,0": "line 3: force_uncertainty_n is 0; it must be above 0",
    HEAD.replace("mN", "kg")
    + ROW: "measured.csv: column 'force [kg]' needs a unit, one of force_n, force_mn;",
    HEAD.replace("hv [µm]", "hv [µm/N]")
    + ROW: "measured.csv: column 'hv [µm/N]' needs a unit, one of hv_m",
    HEAD.replace("force [mN]", "thrust") + ROW: "measured.csv: unknown column 'thrust'",
    HEAD + ",h0 uncertainty [nm]\n5,4,9,1,2e3": "line 2 with its uncertainties: hv = 4 µm",
}


@pytest.mark.parametrize(("measured", "upper", "squares", "beyond", "worth"), WORTH)
def test_chi_square_is_that_found_by_hand(measured, upper, squares, beyond, worth):
    """Three points of 10 N, each with an uncertainty of √(0.6² + 0.8²), and one without a force."""
    table = pd.DataFrame({"measured_force_n": measured, "modelling_error_upper_n": upper})
    table = table.assign(point_id=[*"abcd"], status=[*3 * ["ok"], "not converged"], force_n=10.0)
    table[FORCE_UNCERTAINTY_COLUMNS] = [0.6, 0.8, 0.0]
    table[["force_error_n", "profile_uncertainty_n", "modelling_error_lower_n"]] = 0.0
    got = chi_square_summary(with_residuals(table))
    assert [got["chi_square"], got["chi_square_unexplained"]] == pytest.approx([squares, beyond])
    assert worth in got["verdict"]


def test_measured_forces_of_a_spreadsheet_in_german_are_read(tmp_path):
    path = tmp_path / "measured.csv"
    path.write_bytes(f"Prüfstand 2\n\n{GERMAN}".encode("cp1252"))
    row = read_measurements(path).iloc[0]
    names = ["point_id", "h0_m", "hv_m", "force_n", "force_uncertainty_n"]
    assert row[names].tolist() == ["line 4", 5e-6, 1e-6, 0.0095, 0.002]


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_table_is_refused_before_anything_runs(text, edited, refused, tmp_path):
    (tmp_path / "measured.csv").write_text(text, encoding="utf-8")
    told = refused("config", edited("synthetic", measurements={"file": "measured.csv"}))
    assert WRONG[text] in told


def test_the_synthetic_forces_are_explained_by_inertia(repository):
    path = repository / "config/synthetic.yaml"
    made = synthetic_forces(path.read_text(encoding="utf-8"), path)
    assert made.to_numpy() == pytest.approx(pd.read_csv(path.with_suffix(".csv")), abs=0.011)
    table = compare_measurements(load_config(path))
    assert "the modelling error can explain them" in chi_square_summary(table)["verdict"]
    # The force goes as hv² at small amplitudes.
    assert table["force_uncertainty_hv_n"][9] == pytest.approx(0.02 * table["force_n"][9], rel=0.02)

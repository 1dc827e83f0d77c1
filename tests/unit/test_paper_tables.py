"""Tables I to III: parameters, ranges and errors of the results, tidy and for people."""

import pytest

from paper.tables import TABLES


@pytest.mark.parametrize(
    ("number", "fits", "plan"),
    [
        ("1", ["screen", "two_factor_design"], "screen"),
        ("3", ["four_factor", "four_factor_design", "four_factor_design_distinct"], "four_factor"),
    ],
)
def test_parameters_and_errors_are_those_of_the_fits(study, number, fits, plan):
    data = TABLES[number](study.results).data
    for name, (_, rows) in zip(fits, data.groupby("fit", sort=False), strict=True):
        fit = study.results.fit(name)
        assert tuple(rows["value"][:-1]) == pytest.approx(fit.theta)
        assert set(rows["points"]) == {fit.points}
        error = fit.global_error
        if name != plan:
            error = study.results.validation(name, plan)["global_error"]
        assert rows["value"].iloc[-1] == pytest.approx(100 * error)


def test_ranges_of_the_four_factors(study):
    data = TABLES["2"](study.results).data
    ranges = data.set_index("symbol")[["minimum", "maximum"]].T.to_dict("list")
    assert ranges == {"h0": [5, 10], "hv": [0.2, 2], "φr": [0, 2.9], "φφ": [0, 45]}

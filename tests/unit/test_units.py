"""Units of formulas: what does not fit is refused, what is not said is inferred."""

import math
import re

import pytest
from reference_forces import FOUR_FACTOR, TWO_FACTOR

from squeezefilm.errors import InputError
from squeezefilm.formatting import column_label, percent_text, result_lines_text
from squeezefilm.models.force_model import ExpressionModel, make_model
from squeezefilm.quantities.model_error import EFFECT_NAMES, Effect, ErrorBudget, budget_row


def model(expression: str, **settings) -> ExpressionModel:
    return make_model("own", {"expression": expression, **settings}, source="models.own")


@pytest.mark.parametrize(
    ("expression", "units"),
    [
        ("t0*(hv/h0)**2", ("N",)),
        ("t0*hv + t1*hv**2", ("N/m", "N/m**2")),
        ("t0*(1 + t1*x + t2*y**2)", ("N", "1/m", "1/m**2")),
        ("t0*exp(-t1*h0)*(hv/h0)**t2", ("N", "1/m", "1")),
        ("sqrt(t0*h0)", ("N**2/m",)),
        ("limit + t0*sigma**1.5", ("N",)),
    ],
)
def test_the_units_of_parameters_follow_from_the_formula(expression, units):
    assert model(expression).parameter_units == units


def test_the_papers_parameters_have_the_units_that_the_paper_uses():
    assert TWO_FACTOR.parameter_units == ("1", "1", "1")
    assert FOUR_FACTOR.parameter_units == ("1", "1", "1", "1", "1/m")
    assert FOUR_FACTOR.formula_text.endswith(
        "phi/phi_1 + theta4*r)*(hv/h0)**2) + theta2; phi_1 = 45 deg"
    )


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("h0 + phi", "'h0 . phi' adds quantities in m and in deg"),
        ("1 + h0", "'1 . h0' adds quantities without unit and in m"),
        ("cos(phi)", "radians is called `angle`"),
        ("hv", "the result is in m; a force in N"),
    ],
)
def test_units_that_do_not_fit_are_refused_with_the_part(expression, message):
    with pytest.raises(InputError, match=rf"models\.own\.expression: .*{message}"):
        model(expression)


def test_a_declared_unit_is_held_against_the_formula():
    fits = model("t0*hv", parameters={"t0": "Pa*m"})
    assert fits.parameter_units == ("N/m",)
    with pytest.raises(InputError, match="result is in m"):
        model("t0*hv", parameters={"t0": 1})
    with pytest.raises(InputError, match=r"t0, unit: .*'furlong'"):
        model("t0*hv", parameters={"t0": "furlong"})
    with pytest.raises(InputError, match="is no unit"):
        model("t0*hv", parameters={"t0": "N+N"})


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"parameters": ["h0"]}, "'h0' cannot name a parameter"),
        ({"expression": "slope*hv"}, "'slope': this name is unknown"),
        ({"expression": "t0*cos(x/wavelength)"}, r"constants: \{wavelength: 12 mm\}"),
        ({"expression": " + ".join(f"t{i}*hv" for i in range(31))}, "'t30'"),
    ],
)
def test_names_are_checked(settings, message):
    with pytest.raises(InputError, match=message):
        model(**({"expression": "t0*hv"} | settings))


def test_a_position_is_cartesian_unless_the_formula_is_polar():
    assert model("t0*x").factor_names == ("h0_m", "hv_m", "x_m", "y_m")
    assert model("t0*r*cos(angle)").factor_names == ("h0_m", "hv_m", "phi_r_m", "phi_deg")
    assert model("t0*hv").factor_names == ("h0_m", "hv_m")
    assert model("limit").factor_names == ("h0_m", "hv_m", "x_m", "y_m")


def test_a_row_in_lines_has_texts_and_says_what_is_not_known():
    row = {"h0_m": 4e-6, "damping_ratio": math.nan, "gain_percent": 5263.0}
    shown = [line.split("  ")[-1].strip() for line in result_lines_text(row).splitlines()]
    assert shown == ["not available", "5263 %", "h0 = 4 µm"]
    assert percent_text(-0.499, 7e-5) == "-0.50 to +0.000070 %"
    assert percent_text(-18.1, -18.2) == "-18 %"


def test_a_stiffness_is_shown_without_an_exponent():
    row = {"static_stiffness_n_per_m": 61760.0, "static_stiffness_error_n_per_m": 820.0}
    assert result_lines_text(row) == "static stiffness  61.76 ± 0.82 kN/m"
    assert result_lines_text({"static_stiffness_n_per_m": 320.0}) == "static stiffness  320 N/m"
    row = {"static_stiffness_n_per_m": 3.736e7, "static_stiffness_error_n_per_m": 1.7e5}
    assert result_lines_text(row) == "static stiffness  37.36 ± 0.17 MN/m"


def test_a_zero_has_no_sign():
    assert result_lines_text({"centre_x_m": -0.0, "centre_x_error_m": 0.0}) == "centre x  0 ± 0 m"


def test_friction_is_shown_of_a_sliding_pad():
    row = {"sliding_friction_n": 2e-3, "sliding_friction_error_n": 1e-6}
    assert "sliding friction" in result_lines_text(row | {"bearing_number": 3.0})
    at_rest = {"thrust_x_n": 1e-3, "thrust_x_error_n": 1e-6, "bearing_number": 0.0}
    assert result_lines_text(at_rest | row) == "thrust x  0.0010000 ± 1.0e-06 N"


def test_a_derivative_by_the_prandtl_number_names_it():
    assert column_label("dforce_dprandtl") == "dF/d Prandtl number"


@pytest.mark.parametrize(
    ("row", "shown"),
    [
        ({"settling_start_s": 1e-4, "settling_start_error_s": 1e-4}, "0.2 ms"),
        ({"resonance_hz": 112.4, "resonance_error_hz": 111.6}, "230 Hz"),
        ({"damping_ratio": 0.23, "damping_ratio_error": 0.97}, "1.2"),
    ],
)
def test_an_error_as_large_as_a_value_that_is_never_negative_leaves_a_bound(row, shown):
    text = result_lines_text(row).partition("  ")[2]
    assert text == f"below about {shown} (error as large as the value)"
    _, error_name = row
    assert "below" not in result_lines_text(row | {error_name: 1e-3 * row[error_name]})


def test_an_effect_far_below_its_error_is_shown_as_a_bound():
    effects = {name: Effect(0.0, 0.0) for name in EFFECT_NAMES}
    effects |= {"flow_factor": Effect(-0.00033, 0.06), "depth_averaged": Effect(-1.1, 1.0)}
    row = budget_row(ErrorBudget(effects, 0.0, (-2.2, 0.0))) | {"force_n": 0.1}
    lines = dict(re.split(r"\s{2,}", line.strip()) for line in result_lines_text(row).splitlines())
    assert lines["slip beyond first order"] == "within ± 0.061 %"
    assert lines["depth averaged"] == "-0.0011 N, -1.1 % ± 1.0 %"

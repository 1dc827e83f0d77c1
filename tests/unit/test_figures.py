"""What figures of a study show, drawn from small tables."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm_workflow.paper.figures import four_factor, patterns
from squeezefilm_workflow.reporting.figures import film, maps, models, parts, style
from squeezefilm_workflow.reporting.results import Results

EFFECTS = ("inertia", "slip", "thermal", "edge_loss", "edge_flow")
SCREEN = pd.DataFrame(product([5e-6, 7e-6, 9e-6], [0.5e-6, 1e-6, 1.5e-6, 2e-6]))
SCREEN = SCREEN.set_axis(["h0_m", "hv_m"], axis="columns")


def results(**tables):
    """The results of a study that has these tables alone."""
    return SimpleNamespace(
        validity_note="",
        budget=lambda plan, *effects: tables[plan],
        scenes=lambda plan: SCREEN,
        table=lambda file, *columns: tables[file.rpartition("/")[2]],
    )


def budget(included):
    table = SCREEN.assign(included_effects=included, phi_r_m=0.0, phi_deg=0.0)
    for number, name in enumerate(EFFECTS, start=1):
        table[f"{name}_percent"] = number * 1e5 * table["h0_m"]
    ends = {f"modelling_error_{end}_percent": table["slip_percent"] for end in ("lower", "upper")}
    ends["modelling_error_upper_percent"] = ends["modelling_error_lower_percent"] + 0.5
    return table.assign(edge_flow_error_percent=np.linspace(0.1, 0.3, len(table)), **ends)


@pytest.mark.parametrize(
    ("included", "shown"),
    [
        ([[]] * 12, "inertia, neglected (%)"),
        ([["inertia"]] * 12, "inertia, included (%)"),
        ([[]] * 4 + [["inertia", "thermal"]] * 8, "inertia, included in 8 of 12 (%)"),
    ],
)
def test_a_panel_of_the_budget_says_whether_its_effect_is_in_the_forces(included, shown):
    table = budget(["; ".join(names) for names in included])
    positions = pd.concat([table, table.assign(phi_r_m=1e-3), table.assign(phi_deg=45.0)])
    with style.figure_style():
        figure = film.error_budget(results(screen=table, four_factor=positions))
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[0] == f"(a) {shown}"
    assert titles[1] == "(b) slip, neglected (%)"
    note = " ".join(figure.texts[0].get_text().split())
    assert "(e): ± 0.10 to 0.30 %. Total: middle of the interval, (f): ± 0.25 %" in note


def test_a_budget_of_an_earlier_version_is_answered_with_what_mends_it(paper, tmp_path):
    table = budget([""] * len(SCREEN)).assign(unknown_effects="")
    path = tmp_path / "simulations/screen/error_budget.csv"
    path.parent.mkdir(parents=True)
    table.drop(columns="edge_flow_percent").to_csv(path, index=False)
    told = "error_budget.csv: column 'edge_flow_percent' is missing; .*; run `snakemake "
    with pytest.raises(InputError, match=told):
        film.error_budget(Results(tmp_path, paper))


def test_a_study_without_compared_models_is_told_how_to_compare_them(repository, tmp_path, refused):
    told = refused("recommend", tmp_path, "--config", repository / "config/paper.yaml")
    assert "there is no such table; run `snakemake models " in told


def test_levitation_shows_every_amplitude_and_no_line_of_contact_crosses_another_amplitude():
    table = SCREEN.assign(load_n=1e-6 / SCREEN["h0_m"] * SCREEN["hv_m"] / 1e-6, status="ok")
    table = table.assign(stiffness_n_per_m=1e5, modified_reynolds=1.0)
    ends = dict.fromkeys(("h0_modelling_error_lower_m", "h0_modelling_error_upper_m"), 1e-8)
    with style.figure_style():
        figure = film.levitation(results(**{"levitation.csv": table.assign(**ends)}))
    assert any("Dotted: h0 = hv (contact)" in text.get_text() for text in figure.texts)
    gap, stiffness = figure.axes
    assert len(stiffness.get_legend().get_texts()) == 4
    curves = [line for line in gap.lines if line.get_label().startswith("$h_v$")]
    dotted = [line for line in gap.lines if line.get_linestyle() == ":"]
    assert len({to_hex(line.get_color()) for line in dotted}) == len(curves) == len(dotted) == 4
    for line, curve in product(dotted, curves):
        beside = curve.get_xdata() > min(line.get_xdata())
        assert (curve.get_ydata()[beside] > max(line.get_ydata())).all()
    contact_um = [line.get_ydata()[0] for line in dotted]
    assert contact_um == pytest.approx(sorted(1e6 * SCREEN["hv_m"].unique()))


def test_a_response_states_every_limit_that_films_exceed():
    """The first film's, above 3, stood for all, of which some were above 10."""
    gap_um = 1e6 * SCREEN["h0_m"]
    table = SCREEN.assign(corner_hz=100 * gap_um, corner_error_hz=1.0, status="ok")
    table = table.assign(instantaneous_fraction=0.1 * gap_um, instantaneous_fraction_error=0.01)
    ends = {5: "ok", 7: "Re = 3.3 is above 3", 9: "Re = 10.2 is above 10"}
    table["validity"] = gap_um.round().map(ends)
    table["phi_r_m"] = table["phi_deg"] = 0.0
    gains = pd.concat([table.assign(frequency_hz=hz, gain=2.0) for hz in (10.0, 100.0)])
    gains = gains.assign(phase_deg=-1.0, error=0.01)
    with style.figure_style():
        figure = film.response(results(**{"response.csv": table, "gains.csv": gains}))
    note = " ".join(text.get_text() for text in figure.texts).replace("\n", " ")
    assert "4 of 12 films: Re is above 3; 4 of 12 films: Re is above 10." in note


@pytest.mark.parametrize(
    ("profile", "lowest"),
    [("{kind: formula, expression: cos(500*x)}", -1.0), ("{kind: piston}", 0.0)],
)
def test_the_picture_of_a_vibration_has_its_sign(profile, lowest, tmp_path):
    study = tmp_path / "study.yaml"
    study.write_text(
        "study: mine\nactuator:\n  frequency: 30 kHz\n  surface: {shape: rectangle, "
        f"length_x: 60 mm, length_y: 40 mm}}\n  profile: {profile}\npad: {{length_x: 8 mm, "
        "length_y: 8 mm}\nscreen:\n  h0: {start: 5 µm, stop: 9 µm, levels: 3}\n"
        "  hv: {start: 1 µm, stop: 2 µm, levels: 3}\nextrapolation: {force: 0.1 N}\n",
        encoding="utf-8",
    )
    with style.figure_style():
        figure = maps.vibration(SimpleNamespace(config=load_config(study), validity_note=""))
    bar = figure.axes[-1]
    assert bar.get_ylim() == pytest.approx((lowest, 1.0))
    note = " ".join(text.get_text() for text in figure.texts)
    assert ("opposite phase" in note) == (lowest < 0)


def test_the_colours_of_the_forces_reach_over_all_of_them():
    forces = SCREEN.assign(force_n=np.geomspace(0.0012, 0.78, len(SCREEN)), force_error_n=1e-6)
    target = SimpleNamespace(extrapolation=SimpleNamespace(force_n=0.1))
    with style.figure_style():
        figure = maps.forces(
            SimpleNamespace(config=target, validity_note="", forces=lambda plan: forces)
        )
    low, high = figure.axes[-1].get_ylim()
    assert low <= 0.0012
    assert high >= 0.78


def test_a_note_is_as_wide_as_its_figure():
    line = (
        "Beyond Re 10 from h0 = 34.6 µm: Re = ρωh0²/μ is 10.2 at 35 µm (thermal effects included)."
    )
    with style.figure_style():
        figure = style.new_figure()
        style.add_note(figure, line)
        (note,) = figure.texts
        inside = note.get_window_extent()
    assert note.get_text().replace("\n", " ") == line
    assert inside.x1 <= figure.bbox.x1


def test_positions_that_share_no_coordinate_are_not_joined():
    table = budget([""] * 12).drop(columns=["phi_r_m", "phi_deg"]).assign(x_m=0.0, y_m=0.0)
    positions = pd.concat(table.assign(x_m=1e-3 * k, y_m=2e-3 + 1e-3 * k**2) for k in range(5))
    with style.figure_style():
        figure = film.error_budget(results(screen=table, four_factor=positions))
    lines = [line for line in figure.axes[6].lines if len(line.get_xdata()) == 5]
    assert len(lines) == 6
    assert all(line.get_linestyle() == "None" for line in lines)


@pytest.mark.parametrize(
    ("scaling", "measure"), [("unit", "factors scaled to [0, 1]"), ("metre", "factors in m")]
)
def test_the_criterion_of_a_pattern_is_told_in_the_measure_that_it_has(scaling, measure):
    points = [{"h0_m": 5e-6, "hv_m": 2e-6}, {"h0_m": 5e-6, "hv_m": 1e-6}]
    pattern = {"pattern": "A", "count": 3, "objective": 4.0, "points": points}
    summary = {"searches": 3, "scaling": scaling, "scalings": {scaling: [pattern]}}
    study = SimpleNamespace(
        validity_note="", scenes=lambda plan: SCREEN, read_json_file=lambda file: summary
    )
    figure, _ = patterns.fig10(study)
    notes = " ".join(text.get_text() for text in [*figure.texts, *figure.axes[0].texts])
    assert f"Criterion (12), force in N, {measure}: 4." in " ".join(notes.split())


def test_levels_of_contours_stand_upright_and_none_is_cut_by_the_rim():
    """A minus sign lay on its line, as one more dash."""
    with style.figure_style():
        _, axes = style.subplots()
        x, y = np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 21))
        lines = axes.contour(x, y, x + y - 1, levels=[-0.99, -0.5, 0.5])
        parts.label_contours(axes, lines, "{:+g}".format)
    labels = {text.get_text(): text for text in axes.texts}
    assert {text.get_rotation() for text in labels.values()} == {0.0}
    assert [name for name, text in labels.items() if text.get_visible()] == ["-0.5", "+0.5"]


def test_the_optimal_points_are_drawn_over_axes_from_zero():
    """Below radius 0 there was room for numbers that no pad can have."""
    design = SCREEN.iloc[[0, 3, 11]].assign(phi_r_m=[0, 2e-3, 3e-3], phi_deg=[0, 0, 45.0])
    own = SimpleNamespace(design=lambda name: design, scenes=lambda plan: design, validity_note="")
    with style.figure_style():
        figure, _ = four_factor.fig16(own)
    assert [axes.get_ylim()[0] for axes in figure.axes] == [0, 0]


def test_the_star_of_a_refinement_has_its_meaning_in_the_legend():
    rounds = {"simulations": [8, 10], "global_error": 0.01, "global_lower": 0.005}
    rounds |= {"global_upper": 0.02, "worst_error": [0.05, 0.03]}
    truth = {"simulations": 10, "held_out_worst_error": 0.02, "held_out_global_error": 0.01}
    required = {"worst_error": 0.05, "global_error": 0.02}
    with style.figure_style():
        _, axes = style.subplots()
        models._draw_refinement_rounds(
            axes, pd.DataFrame(rounds), required=required, truth=pd.Series(truth)
        )
    handles, names = axes.get_legend_handles_labels()
    markers = {name: handle.get_marker() for handle, name in zip(handles, names, strict=True)}
    assert markers["at unused simulations"] == "*"

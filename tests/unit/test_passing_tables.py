"""A table that a command writes is read by every command that takes such a table."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from squeezefilm.cli.main import main
from squeezefilm.errors import InputError
from squeezefilm_workflow.reporting.figures import style
from squeezefilm_workflow.reporting.figures.curve import curve_figure

POINTS = ["--h0=5um:9um:3", "--hv=0.5um:1.5um:3"]
# Of each table the command that writes it; {TABLE} stands for another one, or a fit.
WRITERS = {
    "forces": ["simulate", "{given}"],
    "curve": ["simulate", *POINTS],
    "map": ["simulate", "--h0=5um", "--hv=1um", "--x=0mm,1mm", "--y=0mm,1mm"],
    "along": ["simulate", "--h0=5um", "--hv=1um", "--phi-r=0mm,1mm"],
    "preview": ["simulate", "{given}", "--dry-run"],
    "budget": ["error-budget", *POINTS[:1], "--hv=1um"],
    "levitation": ["levitate", "--load=0.1N,0.2N", "--hv=1um"],
    "response": ["response", "{given}"],
    "fit": ["fit", "{curve}", "--model=two_factor", "--seeds=1"],
    "predictions": ["predict", "{fit}", "--points={curve}"],
    "amplitudes": ["amplitude-for", "{fit}", "--force=0.2N", "--h0=5um,6um"],
    "errors": ["validate", "{fit}", "{curve}"],
    "designs": ["optimal", "{fit}", "--forces={forces}"],
}
WITHOUT_STUDY = ("predict", "amplitude-for", "plot")
FORCES = ("forces", "curve")
DRAWN = (*FORCES, "map", "along", "levitation", "predictions", "amplitudes")
SCENES = [name for name in WRITERS if name != "fit"]
READERS = {
    "simulate": (["simulate"], SCENES),
    "error-budget": (["error-budget"], SCENES),
    "predict": (["predict", "{fit}", "--points"], SCENES),
    "response": (["response"], SCENES),
    "optimal": (["optimal", "{fit}", "--forces={curve}", "--existing"], ("curve", "designs")),
    "fit": (["fit", "--model=two_factor", "--seeds=1"], FORCES),
    "validate": (["validate", "{fit}"], FORCES),
    "plot": (["plot"], DRAWN),
}
ENDINGS = {"fit": "json", "plot": "svg"}


@pytest.fixture(scope="module")
def study(repository, tmp_path_factory) -> Path:
    """A study of a pad that is a disc, and a table of scenes as a spreadsheet writes it."""
    folder = tmp_path_factory.mktemp("tables")
    text = (repository / "config/quick.yaml").read_text(encoding="utf-8")
    text = text.replace("shape: rectangle", "shape: ellipse").replace("paper: true", "paper: false")
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    (folder / "given.csv").write_text("h0 [µm];hv [µm]\n5;1,5\n6;1,0\n7;0,5\n8;1,0\n9;0,5\n")
    return folder / "study.yaml"


@pytest.fixture(scope="module")
def run(study):
    """A function that runs a command on tables of the study's folder, and returns what it wrote."""

    def run(words: list[str], name: str) -> Path:
        folder = study.parent
        output = folder / f"{name}.{ENDINGS.get(words[0], 'csv')}"
        tables = {path.stem: path for path in folder.glob("*.*")}
        words = [word.format(**tables) for word in words] + [f"--output={output}"]
        words += [] if words[0] in WITHOUT_STUDY else [f"--config={study}"]
        assert main(words) == 0, words
        return output

    return run


@pytest.fixture(scope="module")
def written(run) -> dict[str, Path]:
    return {name: run(words, name) for name, words in WRITERS.items()}


@pytest.mark.parametrize("reader", READERS)
def test_every_table_is_read_by_every_command_that_takes_such_a_table(reader, run, written):
    words, tables = READERS[reader]
    for name in tables:
        output = run([*words, str(written[name])], f"{reader}-{name}")
        if output.suffix == ".csv" and reader in ("simulate", "error-budget", "predict"):
            read, given = pd.read_csv(output), pd.read_csv(written[name])
            assert read["h0_m"].tolist() == given["h0_m"].tolist(), (reader, name)


def points(**changes: object) -> pd.DataFrame:
    """Forces of a pad at four places, as `simulate` writes them."""
    rows = pd.DataFrame({"x_m": [0.0, 0.0, 1e-3, 1e-3], "y_m": [0.0, 1e-3, 0.0, 1e-3]})
    known = {"h0_m": 5e-6, "hv_m": 1e-6, "force_n": [1.0, 0.9, 0.8, 0.7], "force_error_n": 1e-6}
    return rows.assign(**{**known, "validity": "ok", "study": "mine", **changes})


def test_forces_over_x_and_y_are_a_map_that_names_gap_amplitude_and_study():
    figure = curve_figure(points())
    map_axes, bar = figure.axes
    assert (map_axes.get_xlabel(), map_axes.get_ylabel()) == (
        "position $x$ (mm)",
        "position $y$ (mm)",
    )
    assert bar.get_ylabel() == "mean force $F$ (N)"
    assert map_axes.get_title() == "$h_0$ = 5 µm, $h_v$ = 1 µm, study mine"
    assert figure.texts[0].get_text().startswith("Numerical error: at most 1.0e-06 N.")
    on_a_line = points(y_m=[0.0, 1e-3, 2e-3, 3e-3], x_m=[0.0, 1e-3, 2e-3, 3e-3])
    with pytest.raises(InputError, match="the positions lie on a line"):
        curve_figure(on_a_line)


@pytest.mark.parametrize("y_m", [[0.0, 1e-3, 0.0, 1e-3], [0.0, 5e-4, 0.0, 5e-4], [-3e-3, 0] * 2])
def test_a_map_fills_its_figure_below_a_whole_title(y_m):
    """The title lay above the picture, over an empty band as high as the labels."""
    with style.figure_style():
        figure = curve_figure(points(y_m=y_m))
        style.freeze_layout(figure)
        figure.draw_without_rendering()
        lowest = figure.axes[0].get_tightbbox().y0
    top, below = figure.bbox.height, figure.texts[0].get_window_extent().y1
    assert figure.axes[0].title.get_window_extent().y1 <= top
    assert below <= lowest <= below + 0.15 * top


def test_the_largest_error_of_a_figure_is_rounded_up():
    """0.01325 was at most 0.013."""
    figure = curve_figure(
        points(x_m=0.0, y_m=0.0, h0_m=[5e-6, 6e-6, 7e-6, 8e-6]).assign(force_error_n=0.01325)
    )
    assert "Bars: numerical error, at most 0.014 N." in figure.texts[0].get_text()


@pytest.mark.parametrize("names", [("x_m", "y_m"), ("phi_r_m", "phi_deg"), ()])
def test_a_curve_of_a_centred_pad_names_it_in_words(names):
    rows = points(h0_m=[5e-6, 6e-6, 7e-6, 8e-6]).drop(columns=["x_m", "y_m"])
    figure = curve_figure(rows.assign(**dict.fromkeys(names, 0.0)))
    assert figure.axes[0].get_title() == "$h_v$ = 1 µm, pad centred, study mine"


def test_curves_are_told_apart_without_colours_and_name_what_is_constant():
    figure = curve_figure(
        points(x_m=-2e-3, y_m=0.0, h0_m=[5e-6, 6e-6, 5e-6, 6e-6], hv_m=[1e-6, 1e-6, 2e-6, 2e-6])
    )
    (axes,) = figure.axes
    assert axes.get_title() == "$x$ = −2 mm, $y$ = 0 mm, study mine"
    markers = [bars.lines[0].get_marker() for bars in axes.containers]
    assert len({*markers}) == len(markers) == 2


def test_a_point_without_a_gap_is_counted_and_not_drawn():
    table = points(x_m=0.0, y_m=0.0, load_n=[1.0, 2.0, 3.0, 4.0], h0_m=[5e-6, 4e-6, 3e-6, None])
    table = table.drop(columns=["force_n", "force_error_n"]).assign(status="ok")
    figure = curve_figure(table)
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("load (N)", "gap $h_0$ (µm)")
    assert axes.containers[0].lines[0].get_ydata() == pytest.approx([5, 4, 3])
    assert "Without a result: 1 of 4 points; status has the reason." in figure.texts[0].get_text()
    assert axes.lines[-1].get_xdata().tolist() == [4.0]
    predicted = curve_figure(table.drop(columns="status")).texts[0].get_text()
    assert "1 of 4 points; validity or note has the reason." in predicted


def test_a_levitation_is_drawn_with_its_modelling_error_stiffness_and_resonance():
    table = points(x_m=0.0, y_m=0.0, load_n=[1.0, 2.0, 3.0, 4.0], h0_m=[6e-6, 5e-6, 4e-6, 3e-6])
    table = table.drop(columns=["force_n", "force_error_n"]).assign(
        h0_error_m=1e-9,
        h0_modelling_error_lower_m=-5e-7,
        h0_modelling_error_upper_m=-3e-7,
        stiffness_n_per_m=[1e4, 2e4, 3e4, 4e4],
        stiffness_error_n_per_m=10.0,
        resonance_hz=[500.0, 600.0, None, None],
        resonance_error_hz=5.0,
    )
    figure = curve_figure(table)
    gap, stiffness, resonance = figure.axes
    (band,) = gap.collections[-1].get_paths()
    assert band.vertices[:, 1].min() == pytest.approx(2.5)
    assert band.vertices[:, 1].max() == pytest.approx(5.7)
    assert stiffness.get_ylabel() == "static stiffness (kN/m)"
    assert stiffness.containers[0].lines[0].get_ydata() == pytest.approx([10, 20, 30, 40])
    assert resonance.get_ylabel() == "resonance (Hz)"
    note = " ".join(figure.texts[0].get_text().split())
    assert "Bars: numerical error, of the gap h0 at most 0.0010 µm." in note
    assert "Bars of the resonance: averaging, thermal effects and inertia." in note
    assert "Without a resonance: 2 of 4 points; note has the reason." in note
    assert "Bands: the gap with the modelling error." in note
    assert "Hollow" not in note
    without = curve_figure(table.assign(resonance_hz=None))
    assert len(without.axes) == 2
    assert "resonance" not in without.texts[0].get_text()


def test_masses_carried_with_their_weight_are_drawn_over_the_mass():
    table = points(x_m=0.0, y_m=0.0, h0_m=[6e-6, 5e-6, 4e-6, 3e-6], mass_kg=[0.1, 0.2, 0.3, 0.4])
    table = table.drop(columns=["force_n", "force_error_n"]).assign(h0_error_m=1e-9)
    table["load_n"] = 9.81 * table["mass_kg"]
    (axes,) = curve_figure(table).axes
    assert axes.get_xlabel() == "levitated mass $m$ (g)"
    assert axes.containers[0].lines[0].get_xdata() == pytest.approx([100, 200, 300, 400])


def test_gains_are_drawn_over_the_frequency_with_their_absolute_errors():
    table = points(x_m=0.0, y_m=0.0, gain=[2.0, 1.9, 1.6, 1.5], phase_deg=-5.0)
    table = table.drop(columns=["force_n", "force_error_n"]).assign(
        frequency_hz=[10.0, 30.0, 100.0, 300.0], error=[0.01, 0.01, 0.01, 0.02]
    )
    figure = curve_figure(table)
    gain, phase = figure.axes
    assert (gain.get_ylabel(), phase.get_ylabel()) == ("gain", "phase (°)")
    assert (phase.get_xlabel(), phase.get_xscale()) == ("frequency (Hz)", "log")
    (bars,) = gain.containers[0].lines[2]
    assert np.ptp(bars.get_segments()[-1][:, 1]) / 2 == pytest.approx(0.03)
    (bars,) = phase.containers[0].lines[2]
    assert np.ptp(bars.get_segments()[-1][:, 1]) / 2 == pytest.approx(np.degrees(0.02))


def test_forces_after_start_and_stop_are_drawn_over_time_without_errors():
    table = points(x_m=0.0, y_m=0.0, time_s=[0.0, 1e-4, 2e-4, 3e-4], rising_n=[1.0, 2.0, 2.5, 2.6])
    table = table.drop(columns=["force_n", "force_error_n"]).assign(falling_n=[1.5, 0.5, 0.1, 0.0])
    figure = curve_figure(table)
    start, stop = figure.axes
    assert (start.get_ylabel(), stop.get_xlabel()) == ("force after start (N)", "time (ms)")
    assert stop.containers[0].lines[0].get_ydata() == pytest.approx([1.5, 0.5, 0.1, 0.0])
    assert figure.texts[0].get_text() == "Errors: not in the table."


def test_the_bar_of_a_settling_time_does_not_reach_below_zero():
    table = points(x_m=0.0, y_m=0.0, h0_m=[5e-6, 6e-6, 7e-6, 8e-6], corner_hz=500.0)
    table = table.drop(columns=["force_n", "force_error_n"]).assign(
        corner_error_hz=1.0, settling_start_s=2e-4, settling_start_error_s=3e-4
    )
    (bars,) = curve_figure(table).axes[1].containers[0].lines[2]
    assert bars.get_segments()[0][:, 1] == pytest.approx([0, 0.5])


def test_a_prediction_that_is_not_validated_is_drawn_hollow():
    """Without a bar it looked exact."""
    table = points(
        x_m=0.0, y_m=0.0, h0_m=[5e-6, 6e-6, 7e-6, 8e-6], error_95_n=[0.1, 0.1, 0.1, None]
    )
    figure = curve_figure(table.drop(columns="force_error_n"))
    (hollow,) = (
        line for line in figure.axes[0].lines if str(line.get_markerfacecolor()) == "white"
    )
    assert hollow.get_ydata() == pytest.approx([0.7])
    assert "Hollow: not validated, error unknown." in figure.texts[0].get_text()


def test_a_gap_of_unknown_modelling_error_is_drawn_hollow():
    table = points(x_m=0.0, y_m=0.0, load_n=[1.0, 2.0, 3.0, 4.0], h0_m=[6e-6, 5e-6, 4e-6, 3e-6])
    ends = {
        f"h0_modelling_error_{end}_m": [None, -1e-7, -1e-7, -1e-7] for end in ("lower", "upper")
    }
    table = table.drop(columns=["force_n", "force_error_n"]).assign(h0_error_m=1e-9, **ends)
    figure = curve_figure(table)
    (hollow,) = (
        line for line in figure.axes[0].lines if str(line.get_markerfacecolor()) == "white"
    )
    assert hollow.get_ydata() == pytest.approx([6.0])
    assert "Hollow: modelling error unknown." in figure.texts[0].get_text()


def test_the_table_of_a_profile_is_drawn(tmp_path):
    """`squeezefilm profile --table PROFILE.csv`; the line is in the help of `profile`."""
    scan = {"layer": "points", "r_mm": [0.0, 1.0], "amplitude_um": [1.0, 0.8], "residual_um": 0.01}
    drawn = {"layer": "profile", "r_mm": [0.0, 1.0], "error_um": 0.01}
    drawn |= {"profile_min_um": [1.0, 0.8], "profile_max_um": [1.0, 0.8]}
    table = pd.concat([pd.DataFrame(scan), pd.DataFrame(drawn)]).assign(noise_um=0.01)
    table.to_csv(tmp_path / "profile.csv", index=False)
    picture = tmp_path / "profile.svg"
    assert main(["plot", "profile", str(tmp_path / "profile.csv"), "--output", str(picture)]) == 0
    assert "(b) residuals" in picture.read_text(encoding="utf-8")


def test_the_table_of_a_profile_over_x_and_y_is_drawn(tmp_path):
    at = {"x_mm": [0.0, 1.0, 0.0, 1.0], "y_mm": [0.0, 0.0, 1.0, 1.0]}
    scan = at | {"layer": "points", "amplitude_um": [1.0, 0.8, 0.8, 0.6], "residual_um": 0.01}
    drawn = at | {"layer": "map", "profile_um": [1.0, 0.8, 0.8, 0.6]}
    table = pd.concat([pd.DataFrame(scan), pd.DataFrame(drawn)]).assign(noise_um=0.01)
    path, picture = tmp_path / "profile.csv", tmp_path / "profile.svg"
    table.to_csv(path, index=False)
    assert main(["plot", "profile", str(path), "--output", str(picture)]) == 0
    assert "(b) residuals" in picture.read_text(encoding="utf-8")


def test_a_profile_drawn_as_forces_names_the_command_for_it(tmp_path, refused):
    path = tmp_path / "profile.csv"
    path.write_text("layer,r_mm,amplitude_um,residual_um,noise_um\npoints,0,1,0,0.01\n")
    told = refused("plot", str(path), "--output", str(tmp_path / "profile.svg"))
    assert f"{path}: there is nothing to draw" in told
    assert "`squeezefilm plot profile FILE`" in told


def test_results_of_other_commands_do_not_stand_beside_predictions(run, written):
    predicted = pd.read_csv(written["predictions"])
    assert "force_error_n" not in predicted
    assert {"point_id", "h0_m", "hv_m", "force_n", "error_95_n"} <= {*predicted}


@pytest.mark.parametrize("reader", ["fit", "validate"])
def test_forces_at_a_misspelt_position_are_not_taken_for_the_centre(
    reader, written, refused, study, tmp_path
):
    words, path = READERS[reader][0], tmp_path / "forces.csv"
    forces = pd.read_csv(written["curve"]).drop(columns=["x_m", "y_m"], errors="ignore")
    forces.assign(xx_mm=1.0).to_csv(path, index=False)
    words = [word.format(fit=study.parent / "fit.json") for word in words]
    output = tmp_path / f"output.{ENDINGS.get(reader, 'csv')}"
    told = refused(*words, path, f"--config={study}", f"--output={output}")
    assert "unknown column 'xx_mm' (did you mean 'x_mm'?)" in told


def test_an_unknown_model_is_no_fault_of_the_forces(written, refused, study):
    words = ("--model=none", f"--config={study}", "--output=x.json")
    assert "squeezefilm: error: model 'none' is unknown" in refused("fit", written["curve"], *words)


def test_a_file_is_named_once(written, refused, study):
    fit, config = written["fit"], f"--config={study}"
    for words in (
        ["fit", fit.with_name("none.csv"), "--model=two_factor", config, "--output=x.json"],
        ["validate", fit, fit.with_name("none.csv"), config, "--output=x.csv"],
        ["optimal", fit, f"--forces={written['budget']}", config, "--output=x.csv"],
        ["fit", written["budget"], "--model=two_factor", config, "--output=x.json"],
    ):
        told = refused(*words)
        named = next(word for word in map(str, words) if word.rpartition("=")[2].endswith(".csv"))
        assert told.count(named.rpartition("=")[2]) == 1, told


def test_a_levitation_off_centre_keeps_the_position_that_it_was_sought_at(
    tmp_path, repository, capsys
):
    gaps, forces = (str(tmp_path / name) for name in ("gaps.csv", "forces.csv"))
    study = ["--config", f"{repository}/config/levitation.yaml"]
    wanted = ["--load=0.4N", "--hv=3um", "--x=0mm,4mm", "--y=8mm", f"--output={gaps}"]
    assert main(["levitate", *wanted, *study]) == 0
    assert "hv 3 µm, x 4 mm, y 8 mm: gap" in capsys.readouterr().err
    assert main(["simulate", gaps, f"--output={forces}", *study]) == 0
    assert pd.read_csv(forces)["force_n"].to_list() == pytest.approx([0.4, 0.4], rel=2e-3)
    table = pd.read_csv(gaps)
    (axes, _) = curve_figure(pd.concat([table, table.assign(load_n=0.5)])).axes
    assert axes.get_title() == "$h_v$ = 3 µm, $y$ = 8 mm, study levitation"

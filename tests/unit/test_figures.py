"""Figures: every one is drawn from a study's results, whole, labelled, and the same each time."""

import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text

from paper.figures import FIGURES as OF_THE_PAPER
from reporting.figures import FIGURES as OF_ANY_STUDY
from reporting.figures import save, style
from reporting.notes import rounded_up
from reporting.results import Results
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from verification import work_precision as measured

FIGURES = OF_ANY_STUDY | OF_THE_PAPER
STUDYS = ("overview", "error_map", "force_map", "budget", "response", "levitation")
NAMES = (*STUDYS, *(place.removeprefix("figures/") for place in OF_THE_PAPER))
UNITS = {"fig05": "(mm)", "fig06": "(mm)", "fig15": "(mm)", "fig14": "(%)", "uncertainty": "(N)"}
KNOWN_UNITS = ("(µm)", "(mm)", "(°)", "(N)", "(kPa)", "(%)", "(–)", "(Hz)", "(N/µm)")


def drawn(name: str, results: Results):
    with style.settings():
        found = FIGURES[f"figures/{name}"](results)
        figure = found[0] if isinstance(found, tuple) else found
        figure.draw_without_rendering()
    return figure


def texts(figure) -> list[Text]:
    return [text for text in figure.findobj(match=Text) if text.get_text()]


@pytest.mark.parametrize("name", NAMES)
def test_a_figure_is_whole_legible_as_wide_as_a_journal_s_and_has_units(name, study):
    figure = drawn(name, study.results)
    page, inside = figure.bbox, figure.get_tightbbox().transformed(figure.dpi_scale_trans)
    assert page.x0 <= inside.x0 < inside.x1 <= page.x1
    assert page.y0 <= inside.y0 < inside.y1 <= page.y1
    for axes in figure.axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert label == "" or label.endswith(KNOWN_UNITS)
    assert figure.get_figwidth() in (style.SINGLE_COLUMN_IN, style.DOUBLE_COLUMN_IN)
    assert min(text.get_fontsize() for text in texts(figure)) >= 6
    assert any(UNITS.get(name, "(µm)") in axes.get_ylabel() for axes in figure.axes)


def test_the_same_results_give_the_same_files_and_others_do_not(study, tmp_path):
    kinds = ("svg", "png", "plain.png", "csv")
    paths = {run: [tmp_path / f"{run}.{kind}" for kind in kinds] for run in "abc"}
    other = study.changed(
        tmp_path / "other",
        "simulations/screen/forces.csv",
        lambda table: table.assign(force_n=table["force_n"] * (1 + 0.1 * (table.index == 7))),
    )
    for run, results in {"a": study.results, "b": study.results, "c": other}.items():
        save(FIGURES["figures/fig08"], results, paths[run])
    a, b, c = ([path.read_bytes() for path in paths[run]] for run in "abc")
    assert a == b
    assert not any(same == changed for same, changed in zip(a, c, strict=True))
    assert b"Fit on 60 points" in a[0]  # text stays text
    table = pd.read_csv(paths["a"][3])
    assert list(table[table["layer"] == "simulation"]["force_n"]) == list(
        study.results.forces("screen")["force_n"]
    )


def test_a_study_beyond_its_equation_says_so_below_its_figures(study, repository):
    thick = Results(study.root, load_config(repository / "config/levitation.yaml"))
    for name in ("error_map", "budget"):
        assert any("Beyond Re" in text.get_text() for text in texts(drawn(name, thick)))


def test_the_second_pattern_may_be_missing(study, tmp_path):
    results = study.changed(tmp_path, "designs/two_factor.csv", lambda table: table)
    path = tmp_path / "designs/two_factor.json"
    summary = json.loads(path.read_text())
    summary["scalings"]["unit"] = summary["scalings"]["unit"][:1]
    path.write_text(json.dumps(summary))
    said = " ".join(text.get_text() for text in texts(drawn("fig11", results)))
    assert "no such pattern" in said
    assert "All 20 searches ended in other patterns: A (15)" in said


def test_black_dots_lie_outside_the_band(study, tmp_path):
    def off(table: pd.DataFrame) -> pd.DataFrame:
        table.loc[[3, 7], "relative_error"] = [0.4, -0.4]
        return table

    results = study.changed(tmp_path, "validation/two_factor_design_on_screen.csv", off)
    lines = drawn("fig14", results).axes[0].lines
    black = [line for line in lines if line.get_marker() == "o" and line.get_color() == "black"]
    np.testing.assert_allclose(np.sort(black[0].get_ydata()), [-40.0, 40.0])


@pytest.mark.parametrize("name", ["fig15", "fig16"])
@pytest.mark.parametrize(("factor", "ticks"), [(1, [0, 15, 30, 45]), (4, [0, 45, 90, 135, 180])])
def test_all_positions_of_a_study_lie_on_the_axes(name, factor, ticks, study, tmp_path):
    def moved(table: pd.DataFrame) -> pd.DataFrame:
        return table.assign(phi_deg=table["phi_deg"] * factor)

    results = study.changed(tmp_path, "simulations/four_factor/scenes.csv", moved)
    axes = drawn(name, results).axes[-1]
    left, right = axes.get_xlim()
    assert left <= 0 < 45 * factor <= right
    assert set(ticks) <= {tick for tick in axes.get_xticks() if left <= tick <= right}


@pytest.mark.parametrize("shown", [True, False])
def test_without_a_pressure_the_overview_has_no_place_for_one(shown, study, tmp_path):
    file = "simulations/extrapolation/film.csv"
    results = study.results
    if not shown:
        results = study.changed(tmp_path, file, lambda film: film.assign(overpressure_kpa=np.nan))
    labels = [axes.get_ylabel() for axes in drawn("overview", results).axes]
    assert ("p − p₀ (kPa)" in labels) == shown


@pytest.mark.parametrize("known", [0, 1, 3])
def test_a_response_that_few_films_have_is_numbers_and_never_an_empty_scale(known, study, tmp_path):
    def unknown(table: pd.DataFrame) -> pd.DataFrame:
        gaps = sorted(table["h0_m"].unique())
        few = table["h0_m"].isin(gaps[known:])
        return table.assign(
            **{name: table[name].mask(few) for name in ("corner_hz", "prompt_share")}
        )

    file = "simulations/screen/response.csv"
    results = study.changed(tmp_path, file, unknown)
    axes = drawn("response", results).axes[0]
    shown = [text.get_text().strip() for text in axes.texts]
    films = pd.read_csv(tmp_path / file).dropna(subset="corner_hz").sort_values("hv_m")
    if known == 1:
        assert shown == [f"{value:.3g}" for value in films["corner_hz"]]
    elif known == 0:
        assert shown == ["not known"]
    else:
        assert axes.collections


@pytest.mark.parametrize(
    ("place", "file", "row"),
    [
        ("numerics/stability", "numerics/stability.csv", {"verdict": "magic"}),
        ("numerics/work_precision", "numerics/work_precision.csv", {"method": "magic"}),
        ("figures/fig09", "designs/two_factor_searches.csv", {"scaling": "magic"}),
    ],
)
def test_what_has_no_style_is_refused_and_not_left_out(place, file, row, study, tmp_path):
    columns = ("film", "relative_error", "worst_over_allowed")
    source = study.root / file
    results = study.changed(tmp_path, "designs/two_factor.csv", lambda table: table)
    table = pd.read_csv(source) if source.exists() else pd.DataFrame([dict.fromkeys(columns, 1)])
    (tmp_path / file).parent.mkdir(exist_ok=True)
    table.assign(**row).to_csv(tmp_path / file, index=False)
    with pytest.raises(InputError, match=r"no style is known for .*magic"):
        FIGURES[place](results)


def test_every_method_that_is_measured_has_a_style():
    from reporting.figures.verification import STYLES

    assert {measured.SOLVER, measured.BATCH, *measured.METHODS} == set(STYLES)


def test_error_estimates_are_never_rounded_down():
    shown = {2.4e-7: "3e-7", 9.1e-7: "1e-6", 3e-7: "3e-7", 0.0: "0"}
    assert {value: rounded_up(value) for value in shown} == shown


def test_the_command_draws_a_figure_or_names_all_that_there_are(study, tmp_path, refused):
    words = ["plot", "fig99", study.root, "--config", study.config]
    assert "figures are overview, error_map" in refused(*words, "--output", tmp_path / "a.png")
    assert "name ends in .png" in refused(*words, "--output", tmp_path / "a.mp4")
    words[1] = "models/two_factor_errors"
    assert "models/two_factor.csv" in refused(*words, "--output", tmp_path / "a.png")

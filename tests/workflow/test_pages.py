"""Figures, pages and the explorer: whole, legible, the same each time; nothing from elsewhere."""

import json
import re
import shutil

import pandas as pd
import pytest
from matplotlib.text import Text

from paper.figures import FIGURES as OF_THE_PAPER
from reporting.explorer import explorer_page
from reporting.figures import FIGURES as OF_ANY_STUDY
from reporting.figures import save, style
from reporting.pages import body_of, render
from reporting.results import Results
from reporting.summary import headline_values, summary_values
from squeezefilm.config.loading import load_config
from squeezefilm.models.fit_file import read_fit

FIGURES = OF_ANY_STUDY | OF_THE_PAPER
STUDYS = ("overview", "error_map", "force_map", "budget", "response", "levitation")
NAMES = (*STUDYS, *(place.removeprefix("figures/") for place in OF_THE_PAPER))
UNITS = {"fig05": "(mm)", "fig06": "(mm)", "fig15": "(mm)", "fig14": "(%)"}
KNOWN_UNITS = ("(µm)", "(mm)", "(°)", "(N)", "(kPa)", "(%)", "(–)", "(Hz)", "(N/µm)")
LIBRARY = "/* the drawing library */"


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
    assert b"Fit on 12 points" in a[0]  # text stays text
    table = pd.read_csv(paths["a"][3])
    assert list(table[table["layer"] == "simulation"]["force_n"]) == list(
        study.results.forces("screen")["force_n"]
    )


def test_a_study_beyond_its_equation_says_so_below_its_figures(study, repository):
    thick = Results(study.root, load_config(repository / "config/levitation.yaml"))
    assert any("Beyond Re" in text.get_text() for text in texts(drawn("error_map", thick)))


def test_the_command_draws_a_figure_or_names_all_that_there_are(study, tmp_path, refused):
    words = ["plot", "fig99", study.root, "--config", study.config]
    assert "figures are overview, error_map" in refused(*words, "--output", tmp_path / "a.png")
    assert "name ends in .png" in refused(*words, "--output", tmp_path / "a.mp4")
    assert "drawn by" in refused("plot", "overview", *words[2:], "--output", tmp_path / "a.csv")


def test_a_page_shows_tables_text_and_verdicts_and_needs_nothing_else():
    rows = "| a | b |\n| --- | --- |\n| 1 \\| 2 | <b>x</b> |\n| agrees exactly | failed |\n"
    page = render("page.html", body=body_of(f"# A\n\n{rows}"), title="a <b>")
    assert "<h1>A</h1>" in page
    assert "<td>1 | 2</td>" in page
    assert "<td>&lt;b&gt;x&lt;/b&gt;</td>" in page
    assert "<title>a &lt;b&gt;</title>" in page
    coloured = '<td class="good">agrees exactly</td><td class="bad">failed</td>'
    assert coloured in page.replace("\n", "")
    assert not re.search(r"(src|href|url|@import|<script)", page)


def test_the_summary_says_what_how_accurate_and_where_it_differs(study):
    fits, pairs = ["screen", "two_factor_design"], ["two_factor_design_on_screen"]
    values = summary_values(study.results, plans=["screen", "error_map"], fits=fits, pairs=pairs)
    summary = render("summary.md", **values)
    assert "43.27 kHz" in summary
    assert "The study has 48 simulations" in summary
    assert "| screen | 12 | 5 – 10 | 0.2 – 2 | 0 | 0 | 0.00183 – 0.784 |" in summary
    assert "| gas: viscosity_pa_s | 1.81e-05 |" in summary
    assert "| two_factor_design (5 points) | screen (12 points) | " in summary
    assert re.search(r"\| inertia \| \+2.1 \| \+9.\d \|", summary)
    assert re.search(r"- \d+ of \d+ claims of the paper agree\n", summary)


RECOMMENDED = """\
space,model,parameters,validation_points,validation_error,simulations,worst_error,h0_m,x_m,y_m,force_n,hv_m,\
hv_error_95_m,error_95_percent,note
two_factor,limit_1,1,32,0.009,48,0.03,5e-6,0,0,0.3,1.334e-6,3.3e-8,6.3,
four_factor,bump,3,30,0.16,100,0.25,5e-6,5e-3,0,0.3,,,,no amplitude gives it
"""


def test_the_headline_has_the_models_the_amplitudes_and_neglected_effects(
    study, repository, tmp_path
):
    shutil.copytree(study.root, tmp_path, dirs_exist_ok=True)
    (tmp_path / "models/recommended.csv").write_text(RECOMMENDED)
    (tmp_path / "simulations/screen/budget.csv").write_text(
        "h0_m,hv_m,modelling_error_lower_percent,modelling_error_upper_percent,first_order_invalid,"
        "included_effects\n5e-6,1e-6,-1.2,0.5,,\n6e-6,1e-6,-2,11,inertia,\n"
    )
    results = Results.of(tmp_path, repository / "config/plate.yaml")
    text = render("in_short.md", **headline_values(results))
    assert "limit_1, global error 0.9 % on 32 points of the validation sample" in text
    assert "simulations). No model compared is within the study's ±15 %" in text
    assert "| limit_1 | 0 | 0 | 1.33 | 6.3 % |" in text
    assert "| bump | 5 | 0 | none | no amplitude gives it |" in text
    assert (
        "−2 to +11 % of the force, by neglected effects (first-order estimates with bounds" in text
    )


def explorer(study, **models: list[str]) -> tuple[str, dict]:
    """The explorer's page, and the data on it."""
    forces = {
        "screen": study.results.forces("screen"),
        "</script>": study.results.forces("four_factor"),
    }
    page = explorer_page(study.results, **models, forces=forces, drawing_library=LIBRARY)
    return page, json.loads(re.search(r'id="data">(.*?)</script>', page)[1])


def test_models_and_forces_are_on_the_page_to_the_last_digit(study):
    fits = ["two_factor_design", "four_factor"]
    page, data = explorer(study, fits=fits, candidates=[])
    assert [each["moves"] for each in data["fits"]] == [False, True]
    for name, shown in zip(fits, data["fits"], strict=True):
        fit = read_fit(study.root / f"fits/{name}.json")
        numbers = " ".join(f"({each!r})," if each < 0 else f"{each!r}," for each in fit.theta)
        assert numbers in " ".join(page.split())
        assert shown["statement"] == fit.statement
    screen = pd.read_csv(study.root / "simulations/screen/forces.csv")
    plan = [row for row in data["simulations"] if data["plans"][row[0]] == "screen"]
    assert [row[5] for row in plan] == list(screen["force_n"])
    assert [row[1:3] for row in plan] == screen[["h0_m", "hv_m"]].to_numpy().tolist()


def test_nothing_is_left_to_fill_in_and_nothing_comes_from_elsewhere(study):
    page, data = explorer(study, fits=["screen"], candidates=[])
    assert LIBRARY in page
    assert data["plans"] == ["screen", "</script>"]  # a text cannot end the data
    assert not re.search(r"\{\{[\w.]+\}\}", page)
    assert not re.search(r"<(script|img|iframe|link)\b[^>]*(src|href)=\"(?!data:)", page)
    assert not re.search(r"\b(fetch|XMLHttpRequest|import)\s*\(|url\(|@import", page)
    assert "default-src 'none'" in page

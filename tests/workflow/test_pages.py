"""Figures, pages and the explorer: whole, legible, the same each time; nothing from elsewhere."""

import json
import re
import shutil
from collections import defaultdict

import pandas as pd
import pytest
from matplotlib.text import Text

from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.models.fit_file import read_fit
from squeezefilm_workflow.paper.claims import claims_with_verdicts
from squeezefilm_workflow.paper.figures import FIGURES as OF_THE_PAPER
from squeezefilm_workflow.reporting.explorer import explorer_page
from squeezefilm_workflow.reporting.figures import FIGURES as OF_ANY_STUDY
from squeezefilm_workflow.reporting.figures import draw_and_save, style
from squeezefilm_workflow.reporting.figures.curve import curve_figure
from squeezefilm_workflow.reporting.pages import html_of_markdown, render_template
from squeezefilm_workflow.reporting.results import Results
from squeezefilm_workflow.reporting.summary import headline_values, summary_values

FIGURES = OF_ANY_STUDY | OF_THE_PAPER
OPTIONAL = ("figures/profile", "figures/measurements")
PLACES = (*(place for place in OF_ANY_STUDY if place.startswith("figures/")), *OF_THE_PAPER)
NAMES = [place.removeprefix("figures/") for place in PLACES if place not in OPTIONAL]
IN_MM = ("vibration", "amplitudes", "fig05", "fig06", "fig15")
UNITS = dict.fromkeys(IN_MM, "(mm)") | {"fig14": "(%)"}
KNOWN_UNITS = ("(µm)", "(mm)", "(°)", "(N)", "(kPa)", "(%)", "(–)", "(Hz)", "(kN/m)")


def drawn(name: str, results: Results):
    with style.figure_style():
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


def test_a_caption_names_the_last_panel_of_its_figure(study, repository):
    """Of the effects' it was (f), and the figure had a seventh."""
    for name in ("error_budget", "levitation", "response", "fig16"):
        titles = " ".join(axes.get_title() for axes in drawn(name, study.results).axes)
        caption = (repository / f"workflow/report/captions/{name}.rst").read_text(encoding="utf-8")
        # Of a range, (a–e), both ends are named.
        named = re.findall(r"\((?:\w–)?(\w)\)", caption)
        assert max(named) == max(re.findall(r"\((\w)\)", titles)), name


def test_bounds_of_the_modelling_error_are_rounded_outward(study, tmp_path):
    """The nearest were −0.08 and +6.6 in the summary, 0.962 N of 0.96154 N in a claim."""
    bounds = {"modelling_error_lower_percent": -0.0805, "modelling_error_upper_percent": 6.613}
    results = study.changed(
        tmp_path, "simulations/screen/error_budget.csv", lambda table: table.assign(**bounds)
    )
    about = {"fits": ["screen"], "pairs": ["screen_on_screen"]}
    total = summary_values(results, plans=["screen"], **about)["effects"].iloc[-1]
    assert {*total[1:]} == {"−0.1…+6.7"}
    claim = claims_with_verdicts(results).set_index("claim_id").loc["simulation_at_2.2"]
    ends_n = re.findall(r"with all of them ([\d.]+) to ([\d.]+) N", claim["explanation"])[0]
    row = results.budget("extrapolation").set_index("point_id").loc["operating_point"]
    for end_n, percent, sign in zip(ends_n, row[[*bounds]], (-1, 1), strict=True):
        beyond_n = sign * (float(end_n) - float(claim["ours"]) * (1 + percent / 100))
        assert 0 <= beyond_n < 1e-3


def test_figure_14_has_a_panel_of_each_fit_with_its_own_errors(study):
    figure = drawn("fig14", study.results)
    for axes, fit in zip(figure.axes, ("two_factor_design", "screen"), strict=True):
        errors = 100 * study.results.errors(fit, "screen")["relative_error"]
        curves = [line.get_ydata() for line in axes.lines if line.get_label()[0] != "_"]
        assert min(map(min, curves)) == pytest.approx(errors.min())


def test_the_bars_of_a_curve_hold_the_numerical_error_and_that_of_the_scan():
    table = pd.DataFrame({"h0_m": 5e-6, "hv_m": [1e-6, 2e-6], "force_n": [0.2, 0.8]})
    known = {"force_error_n": 1e-6, "measurement_noise_n": 0.02, "quadrature_n": 0.01}
    figure = curve_figure(table.assign(**known, validity="ok"))
    (bars,) = figure.axes[0].containers[0].lines[2]
    for (_, low), (_, high) in bars.get_segments():
        assert (high - low) / 2 == pytest.approx(sum(known.values()))


def test_the_same_results_give_the_same_files_and_others_do_not(study, tmp_path):
    kinds = ("svg", "png", "plain.png", "csv")
    paths = {run: [tmp_path / f"{run}.{kind}" for kind in kinds] for run in "abc"}
    other = study.changed(
        tmp_path / "other",
        "simulations/screen/forces.csv",
        lambda table: table.assign(force_n=table["force_n"] * (1 + 0.1 * (table.index == 7))),
    )
    for run, results in {"a": study.results, "b": study.results, "c": other}.items():
        draw_and_save(FIGURES["figures/fig08"], results, paths[run])
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


def test_a_style_file_of_the_study_is_used_and_a_wrong_one_is_named(study, tmp_path):
    text = study.config.read_text(encoding="utf-8") + "figures: {style: my.mplstyle}\n"
    (tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    results, own = Results.of_folder(study.root, tmp_path / "mine.yaml"), tmp_path / "my.mplstyle"
    own.write_text("font.family: serif\n", encoding="utf-8")
    draw_and_save(FIGURES["figures/fig07"], results, [tmp_path / "a.svg"])
    assert "DejaVu Serif" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    own.write_text("font.famly: serif\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"my.mplstyle: not a style file .*: Bad key font.famly"):
        draw_and_save(FIGURES["figures/fig07"], results, [tmp_path / "a.svg"])


def test_the_command_draws_a_figure_or_names_all_that_there_are(study, tmp_path, refused):
    words = ["plot", "fig99", study.root, "--config", study.config]
    names = refused(*words, "--output", tmp_path / "a.png").partition("figures are ")[2].strip()
    assert {"overview", "response", "vibration"} <= {*names.split(", ")}
    assert names.split(", ") == sorted(names.split(", "))
    assert "name ends in .png" in refused(*words, "--output", tmp_path / "a.mp4")
    assert "drawn by" in refused("plot", "overview", *words[2:], "--output", tmp_path / "a.csv")


def test_a_page_shows_tables_text_and_verdicts_and_needs_nothing_else():
    rows = "| a | b |\n| --- | --- |\n| 1 \\| 2 | <b>x</b> |\n| agrees exactly | failed |\n"
    rows += "| 6.7e-05 | 2 |\n"
    page = render_template("page.html", body=html_of_markdown(f"# A\n\n{rows}"), title="a <b>")
    assert "<h1>A</h1>" in page
    assert "<td>1 | 2</td>" in page
    assert "<td>&lt;b&gt;x&lt;/b&gt;</td>" in page
    assert "<title>a &lt;b&gt;</title>" in page
    assert '<span class="number">6.7e-05</span>' in page
    coloured = '<td class="good">agrees exactly</td><td class="bad">failed</td>'
    assert coloured in page.replace("\n", "")
    assert not re.search(r"(src|href|url|@import|<script)", page)


def test_the_summary_says_what_how_accurate_and_where_it_differs(study):
    fits, pairs = ["screen", "two_factor_design"], ["two_factor_design_on_screen"]
    values = summary_values(study.results, plans=["screen", "error_map"], fits=fits, pairs=pairs)
    summary = render_template("summary.md", **values, pictures=defaultdict(str))
    assert "43.27 kHz" in summary
    assert "The study has 48 simulations" in summary
    assert "| screen | 12 | 5 … 10 | 0.2 … 2 | 0 | 0 | 0.00183 … 0.784 |" in summary
    assert "| gas: viscosity_pa_s | 1.81e-05 |" in summary
    assert "| two_factor_design (5 points) | screen (12 points) | " in summary
    assert re.search(r"\| inertia \| \+2(\.\d)? \| \+8(\.\d)? \|", summary)
    undecided = r"- \d of 6 results of the paper agree.* too small to decide the other 11 "
    assert re.search(undecided, summary)
    assert "undecided with 12 of the paper's 60 screen points |" in summary


def test_the_summary_counts_points_of_a_sample_that_have_no_force(study, tmp_path):
    sample = "simulations/validation_four_factor/forces.csv"
    unsolved = {"status": "not converged", "force_n": None, "force_error_n": None, "method": None}
    results = study.changed(
        tmp_path,
        sample,
        lambda table: table.assign(
            **{name: table[name].where(table.index != 3, value) for name, value in unsolved.items()}
        ),
    )
    plans = ["screen", "validation_four_factor"]
    about = {"fits": ["screen"], "pairs": ["two_factor_design_on_screen"]}
    values = summary_values(results, plans=plans, **about)
    count = len(pd.read_csv(study.root / sample))
    assert values["total"] == 12 + count
    assert values["plans"]["simulations"].tolist() == ["12", str(count)]


def test_the_links_of_the_summary_lead_to_pages_of_the_study(finished):
    page = finished.folder / "results/quick/report/summary.html"
    links = re.findall('href="(.*?)"', page.read_text(encoding="utf-8"))
    assert {"../explorer.html", "claims.html"} <= {*links}
    assert all((page.parent / link).is_file() for link in links if not link.startswith("data:"))


def test_the_summary_lists_every_plan_that_its_errors_are_measured_on(finished):
    page = (finished.folder / "results/quick/report/summary.html").read_text(encoding="utf-8")
    plans = page.partition("in these plans")[2].partition("</table>")[0]
    for plan in ("screen", "four_factor", "validation_two_factor", "validation_four_factor"):
        assert f"<td>{plan}</td>" in plans


RECOMMENDED = """\
space,model,parameters,validation_points,validation_error,simulations,worst_error,h0_m,x_m,y_m,force_n,hv_m,\
hv_error_95_m,error_95_percent,note
two_factor,limit_1,1,32,0.009,48,0.03,5e-6,0,0,0.3,1.334e-6,3.3e-8,6.3,
four_factor,bump,3,30,0.16,100,0.25,5e-6,1e-3,0,0.3,1.4e-6,3e-8,6.0,
four_factor,bump,3,30,0.16,100,0.25,5e-6,5e-3,0,0.3,,,,no amplitude gives it
four_factor,bump,3,30,0.16,100,0.25,5e-6,2e-3,0,0.3,1.5e-6,3e-8,6.0,
"""


def test_the_headline_has_the_models_the_amplitudes_and_neglected_effects(
    study, repository, tmp_path
):
    shutil.copytree(study.root, tmp_path, dirs_exist_ok=True)
    (tmp_path / "models/recommended.csv").write_text(RECOMMENDED)
    (tmp_path / "simulations/screen/error_budget.csv").write_text(
        "h0_m,hv_m,modelling_error_lower_percent,modelling_error_upper_percent,unknown_effects,"
        "included_effects\n5e-6,1e-6,-1.2,0.5,,\n6e-6,1e-6,-2,11,inertia,\n"
    )
    results = Results.of_folder(tmp_path, repository / "config/plate.yaml")
    text = render_template("in_short.md", **headline_values(results), pictures=defaultdict(str))
    model = "Recommended model with the pad at the centre: limit_1, global error 0.9 % on 32 points"
    assert f"{model} of the validation sample" in text
    assert "simulations). No model compared is within the study's ±15 %" in text
    assert "The recommended model bump gives the amplitude for" in text.partition("## In short")[0]
    assert text.index("limit_1, global error") < text.index("**Fit.**")  # the paper's formula last
    # The target first, at its least and largest amplitude: a table had 26 positions of the plan.
    target, _, rest = text.partition("## In short")[2].partition("Positions are those of the plan")
    assert "Amplitude for 0.3 N (`extrapolation.force`) at h0 = 5 µm (`extrapolation.h0`" in target
    assert "| at the centre | limit_1 | 0 | 0 | 1.334 | 6.3 % |" in target
    assert "| anywhere | bump | 1 | 0 | 1.400 | 6.0 % |" in target
    assert "| anywhere | bump | 5 | 0 | none | no amplitude gives it |" in target
    assert "1.500" not in target
    assert "all of them in `models/recommended.csv`; on a wave include a crest" in rest
    assert rest.index("limit_1, global error") < rest.index("F(h0 = ")
    bounds = "−1.2…+0.5 % (h0 = 5 µm) to −2…+11 % (h0 = 6 µm)"
    effects = "the neglected effects that the error budget solves for"
    assert f"{bounds} of the force, by {effects}" in text
    assert ", with 1.1 times the screen's largest amplitude" in text


def test_the_explorer_opens_with_the_model_that_the_study_recommends(study, repository, tmp_path):
    shutil.copytree(study.root, tmp_path, dirs_exist_ok=True)
    (tmp_path / "models/recommended.csv").write_text(
        "space,model\ntwo_factor,limit_1\nfour_factor,limit_2\nfour_factor,limit_2\n"
    )
    results = Results.of_folder(tmp_path, repository / "config/plate.yaml")
    forces = {"screen": results.forces("screen")}
    about = {"fits": ["screen"], "forces": forces, "drawing_library": ""}
    page = explorer_page(results, candidates=["limit_2"], **about)
    fits = json.loads(re.search(r'id="data">(.*?)</script>', page)[1])["fits"]
    names = ["limit_2 on four_factor", "limit_1 on two_factor", "screen"]
    assert [each["name"] for each in fits] == names
    assert "effects of the error budget add −0.07…+0.61 % (h0 = 5 µm) to " in page
    assert [each["label"].endswith(", recommended") for each in fits] == [True, True, False]


def test_models_and_forces_are_on_the_page_to_the_last_digit(study):
    fits = ["two_factor_design", "four_factor"]
    names = {"screen": "screen", "</script>": "four_factor"}
    forces = {shown: study.results.forces(plan) for shown, plan in names.items()}
    text = {"forces": forces, "drawing_library": "/* the drawing library */"}
    page = explorer_page(study.results, fits=fits, candidates=[], **text)
    data = json.loads(re.search(r'id="data">(.*?)</script>', page)[1])  # no text ends it
    assert text["drawing_library"] in page
    assert not re.search(r"\{\{[\w.]+\}\}", page)
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

"""Figures: every one is drawn from its own table, whole, labelled, and the same each time."""

import ast
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text

from reporting.figures import figure_module, installed
from reporting.figures.parts import style
from reporting.pages.notes import one_digit, rounded_up
from reporting.rooms import described
from squeezefilm.cli import main as cli
from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import parse_sources
from squeezefilm.provenance import WORKFLOW
from verification import work_precision as measured

PACKAGES = ("squeezefilm", "verification", "reporting", "paper")
ROOMS = {path.stem: described(path) for path in sorted(WORKFLOW.glob("*/figures/[!_]*.py"))}
FIGURES = [name for name, room in ROOMS.items() if room.builds]
UNITS = {"fig05": "(mm)", "fig06": "(mm)", "fig15": "(mm)", "fig14": "(%)", "uncertainty": "(N)"}
SHOWN = ("amplitude_ratio", "force_n", "relative_error_percent", "hv_um", "phi_r_mm")


@pytest.fixture(scope="module")
def tables(study):
    """The table of each figure, as the command line makes it."""
    paths = {name: study.root / "figures" / f"{name}.csv" for name in FIGURES}
    for name, path in paths.items():
        words = study.words(study.figures[name])
        arguments = ["figure", name, *words, f"--config={study.config}", f"--output={path}"]
        assert cli.main(arguments) == 0
    return paths


def drawn(name: str, data: pd.DataFrame):
    with style.settings():
        figure = figure_module(name).draw(data)
        figure.draw_without_rendering()
    return figure


def saved(name: str, data: pd.DataFrame, path: Path) -> bytes:
    with style.settings():
        style.save(figure_module(name).draw(data), [path])
    return path.read_bytes()


@pytest.mark.parametrize("name", ROOMS)
def test_what_is_read_of_a_figure_is_what_its_module_has(name):
    room, module = ROOMS[name], figure_module(name)
    assert installed()[name] == room.module == module.__name__
    assert room.inputs == module.INPUTS
    assert room.builds == hasattr(module, "build")
    assert callable(module.draw)


def test_table_and_drawing_come_from_one_command_or_the_drawing_from_the_table(
    study, tables, tmp_path
):
    words = study.words(study.figures["fig08"])
    made = [tmp_path / f"fig08.{kind}" for kind in ("csv", "svg", "png")]
    named = ["paper.figures.fig08", *words, f"--config={study.config}"]
    assert cli.main(["figure", *named, "--output", *map(str, made)]) == 0
    again = [tmp_path / f"again.{kind}" for kind in ("svg", "png")]
    assert cli.main(["plot", "fig08", str(made[0]), "--output", *map(str, again)]) == 0
    assert made[0].read_bytes() == tables["fig08"].read_bytes()
    assert [path.read_bytes() for path in made[1:]] == [path.read_bytes() for path in again]


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_whole_legible_as_wide_as_a_journal_s_and_has_units(name, tables):
    figure = drawn(name, pd.read_csv(tables[name]))
    page, inside = figure.bbox, figure.get_tightbbox().transformed(figure.dpi_scale_trans)
    assert page.x0 <= inside.x0 < inside.x1 <= page.x1
    assert page.y0 <= inside.y0 < inside.y1 <= page.y1
    for axes in figure.axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert label == "" or label.endswith(
                ("(µm)", "(mm)", "(°)", "(N)", "(kPa)", "(%)", "(–)", "(Hz)", "(N/µm)")
            )
    assert figure.get_figwidth() in (style.SINGLE_COLUMN_IN, style.DOUBLE_COLUMN_IN)
    sizes = [text.get_fontsize() for text in figure.findobj(match=Text) if text.get_text()]
    assert min(sizes) >= 6
    assert any(UNITS.get(name, "(µm)") in axes.get_ylabel() for axes in figure.axes)


@pytest.mark.parametrize("name", FIGURES)
def test_a_drawing_is_its_tables_and_nothing_elses(name, tables, tmp_path):
    """The same table gives the same bytes, another number in it another drawing."""
    data = pd.read_csv(tables[name])
    svg = saved(name, data, tmp_path / "a.svg")
    assert svg == saved(name, data, tmp_path / "b.svg")
    assert data["note"].iloc[0].split()[0].encode() in svg  # text stays text
    ElementTree.fromstring(svg)
    data.loc[len(data) // 2, next(column for column in SHOWN if column in data)] *= 0.9
    assert saved(name, data, tmp_path / "c.svg") != svg


@pytest.mark.parametrize("name", FIGURES)
def test_a_table_without_a_column_is_refused(name, tables, tmp_path, capsys):
    data, path = pd.read_csv(tables[name]), tmp_path / "t.csv"
    missing = next(column for column in SHOWN if column in data)
    data.drop(columns=missing).to_csv(path, index=False)
    assert cli.main(["plot", name, str(path), "--output", str(tmp_path / "t.png")]) == 2
    message = capsys.readouterr().err
    assert "t.csv" in message
    assert repr(missing) in message


def names_in(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}


@pytest.mark.parametrize("name", ROOMS)
def test_a_drawing_knows_nothing_of_physics(name):
    """What draws uses nothing of ours but what draws: it has its table and no other knowledge."""
    tree = ast.parse(Path(str(figure_module(name).__file__)).read_text(encoding="utf-8"))
    functions = {node.name: names_in(node) for node in tree.body if hasattr(node, "body")}
    used, waiting = set(), {"draw"}
    while waiting:
        used |= waiting
        waiting = set().union(*(functions.get(each, ()) for each in waiting)) - used
    drawing = {"reporting.figures.parts", "paper.figures.parts.patterns"}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] in PACKAGES:
            assert node.module in drawing or not used & {each.name for each in node.names}


def test_the_second_pattern_may_be_missing(study, tables, tmp_path):
    module, inputs = data_of("fig11", study)
    summary = pd.read_json(inputs["summary"], typ="series")
    one = summary.to_dict()
    one["scalings"]["unit"] = one["scalings"]["unit"][:1]
    inputs["summary"] = tmp_path / "one.json"
    pd.Series(one).to_json(inputs["summary"])
    data = module.build(inputs, load_config(study.config))
    figure = drawn("fig11", data)
    said = " ".join(text.get_text() for text in figure.findobj(match=Text))
    assert "no such pattern" in said
    assert "All 20 searches ended in other patterns: A (15)" in data["note"].iloc[0]


def test_black_dots_lie_outside_the_band(tables):
    data = pd.read_csv(tables["fig14"])
    assert data["in_band"].all()
    data.loc[[3, 7], ["relative_error_percent", "in_band"]] = [[40.0, False], [-40.0, False]]
    lines = drawn("fig14", data).axes[0].lines
    black = [line for line in lines if line.get_marker() == "o" and line.get_color() == "black"]
    np.testing.assert_array_equal(np.sort(black[0].get_ydata()), [-40.0, 40.0])


def test_the_error_map_states_global_and_worst_error(tables):
    note = pd.read_csv(tables["error_map"])["note"].iloc[0]
    assert "global error 0.98" in note
    assert "largest relative error −6.4" in note
    assert "no point outside ±15 %" in note
    assert "test device" in note
    assert "≤ 3e-7 of the force" in note


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["forces"], "not NAME=PATH"),
        (["forces=a", "forces=b"], "twice"),
        (["strange=a"], "no input 'strange'"),
        (["forces=a"], "fit is missing"),
    ],
)
def test_inputs_are_checked_by_name(words, message):
    with pytest.raises(InputError, match=message):
        parse_sources(words, names=("forces", "fit"), user="fig08")


def test_an_unknown_figure_is_refused():
    with pytest.raises(InputError, match=r"no figure 'fig99'; the figures are .*, fig05, .*"):
        figure_module("fig99")


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("stability", {"verdict": "magic"}),
        ("fig09", {"scaling": "magic"}),
        ("work_precision", {"method": "magic"}),
    ],
)
def test_what_has_no_style_is_refused_and_not_left_out(name, row):
    with pytest.raises(InputError, match=r"no style is known for .*magic"):
        figure_module(name).draw(pd.DataFrame([row]))


def test_every_method_that_is_measured_has_a_style():
    styles = figure_module("work_precision").STYLES
    assert {measured.SOLVER, measured.BATCH, *measured.METHODS} == set(styles)


def test_error_estimates_are_never_rounded_down():
    shown = {2.4e-7: "3e-7", 9.1e-7: "1e-6", 3e-7: "3e-7", 0.0: "0"}
    assert {value: rounded_up(value) for value in shown} == shown
    assert one_digit(5.2e-06) == "5e-6"


def data_of(name: str, study) -> tuple[ModuleType, dict[str, Path]]:
    return figure_module(name), {k: Path(v) for k, v in study.figures[name].items()}


@pytest.mark.parametrize(
    ("factor", "ticks"),
    [(1, [0, 15, 30, 45]), (2, [0, 30, 60, 90]), (4, [0, 45, 90, 135, 180]), (0, [0])],
)
@pytest.mark.parametrize("name", ["fig15", "fig16"])
def test_all_positions_of_a_study_lie_on_the_axes(name, factor, ticks, tables):
    data = pd.read_csv(tables[name])
    data[[key for key in data if key in ("phi_deg", "phi_max_deg")]] *= factor
    data[[key for key in data if key.startswith("phi_r_")]] *= 0.01  # a small disc
    axes = drawn(name, data).axes[-1]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert data["phi_deg"].between(left, right).all()
    assert data["phi_r_mm"].between(low, high).all()
    assert high - low < 2 * data["phi_r_mm"].max()
    inside = [tick for tick in axes.get_xticks() if left <= tick <= right]
    assert set(ticks) <= set(inside)


def test_without_a_pressure_the_overview_has_no_place_for_one(study, tmp_path):
    module, inputs = data_of("overview", study)
    film = pd.read_csv(inputs["film"])
    config = load_config(study.config)
    for shown in (True, False):
        if not shown:
            inputs["film"] = tmp_path / "film.csv"
            film.assign(overpressure_kpa=np.nan).to_csv(inputs["film"], index=False)
        data = module.build(inputs, config)
        labels = [axes.get_ylabel() for axes in drawn("overview", data).axes]
        assert ("p − p₀ (kPa)" in labels) == shown
        assert ("pressure" in data["note"].iloc[0]) == shown
        assert "16 times of a period" in data["note"].iloc[0]


@pytest.mark.parametrize("known", [0, 1, 3])
def test_a_response_that_few_films_have_is_numbers_and_never_an_empty_scale(known, tables):
    data = pd.read_csv(tables["response"])
    gaps = sorted(data.loc[data["layer"] == "plane", "h0_um"].unique())
    unknown = (data["layer"] == "plane") & data["h0_um"].isin(gaps[known:])
    data.loc[unknown, ["corner_hz", "prompt_percent"]] = np.nan
    axes = drawn("response", data).axes[0]
    texts = [text.get_text().strip() for text in axes.texts]
    films = data[(data["layer"] == "plane") & data["corner_hz"].notna()]
    if known == 1:
        assert texts == [f"{value:.3g}" for value in films.sort_values("hv_um")["corner_hz"]]
    elif known == 0:
        assert texts == ["not known"]
    else:
        assert axes.collections

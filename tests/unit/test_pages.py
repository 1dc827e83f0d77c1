"""Pages: tables stay tables, nothing is taken for code, and the summary tells what it must."""

import json
import re

import pandas as pd
import pytest

from reporting.notes import Inertia
from reporting.pages import front_page, render, to_html, write_pages
from reporting.results import Results
from reporting.summary import headline_values, summary_values
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError

PLANS = ("screen", "two_factor_design", "error_map", "extrapolation", "four_factor")
FITS = ("screen", "two_factor_design", "four_factor_design")
PAIRS = ("two_factor_design_on_screen", "four_factor_design_on_four_factor")


def test_a_page_shows_tables_text_and_verdicts_and_needs_nothing_else():
    rows = "| 1 \\| 2 | <b>x</b> |\n| agrees exactly | failed |\n"
    page = to_html(f"# A\n\n| a | b |\n| --- | --- |\n{rows}", title="a <b>")
    assert "<h1>A</h1>" in page
    assert "<td>1 | 2</td>" in page
    assert "<td>&lt;b&gt;x&lt;/b&gt;</td>" in page
    assert "<title>a &lt;b&gt;</title>" in page
    coloured = '<td class="good">agrees exactly</td><td class="bad">failed</td>'
    assert coloured in page.replace("\n", "")
    assert not re.search(r"(src|href|url|@import|<script)", page)


@pytest.fixture
def summary(study, tmp_path):
    (study.root / "claims.csv").write_text(
        "claim,paper,ours,unit,verdict\na,3,0.5,%,differs because so\nb,1,1,N,agrees exactly\n"
    )
    values = summary_values(study.results, plans=PLANS, fits=FITS, pairs=PAIRS)
    return render("summary.md", **values)


def test_the_summary_says_what_how_accurate_and_where_it_differs(summary):
    assert "43.27 kHz" in summary
    assert "Made were 193 simulations" in summary
    assert "| screen | 60 | 5 – 10 | 0.2 – 2 | 0 | 0 | 0.00183 – 0.784 | 3e-7 |" in summary
    assert "| gas: viscosity_pa_s | 1.81e-05 |" in summary
    assert "the largest estimated error of all forces is 3e-7 of the force" in summary
    assert "| two_factor_design (5 points) | screen (60 points) | 0.98" in summary
    assert re.search(r"\| inertia \| \+2.1 \| \+9.\d \|", summary)
    assert "- 1 of 2 claims of the paper agree\n" in summary
    assert summary.split("## Where it differs")[1].count("| a | 3 | 0.5 | % | so |") == 1
    assert "It re-makes" in summary


def test_the_summary_of_another_actuator_does_not_speak_of_the_paper_s(study, tmp_path):
    """Its claims, and that the study re-makes it; what the scan leaves open is said."""
    results = study.changed(tmp_path, "designs/two_factor.csv", lambda table: table)
    path = tmp_path / "fits/screen.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"profile_uncertainty": 0.016}))
    results = Results(tmp_path, {**results.config, "paper": False})
    values = summary_values(results, plans=PLANS, fits=FITS, pairs=PAIRS)
    own = render("summary.md", **values | {"amplitudes": None, "recommended": []})
    assert "paper" not in own.partition("\n")[2]
    assert "moves a force by up to 1.6 %" in own


def test_pages_of_a_film_beyond_re_10_say_so_below_their_title(repository, tmp_path):
    beyond = {
        name: Results.of(tmp_path, repository / f"config/{name}.yaml").beyond
        for name in ("levitation", "plate")
    }
    assert beyond["plate"] == ""
    page = tmp_path / "a.html"
    write_pages("# Models\n\nA.\n", tmp_path / "a.md", page, beyond=beyond["levitation"])
    text = page.read_text(encoding="utf-8")
    assert text.index("<h1>Models") < text.index("<p><strong>Beyond Re 10 from h0 =")
    for kind, most in (("inertia neglected", 3), ("inertia included", 20)):
        gap_m = (most / 1e10) ** 0.5
        assert Inertia(1e10, kind).note(gap_m) == ""
        assert f"{kind}, error unknown above Re {most}" in Inertia(1e10, kind).note(1.01 * gap_m)


RECOMMENDED = """\
space,model,parameters,validation_points,validation_error,simulations,worst_error,h0_m,x_m,y_m,force_n,hv_m,\
hv_error_95_m,error_95_percent,note
two_factor,limit_1,1,32,0.009,48,0.03,5e-6,0,0,0.3,1.334e-6,3.3e-8,6.3,
four_factor,bump,3,30,0.16,100,0.25,5e-6,0,0,0.3,1.31e-6,,,not validated: hv_m outside
four_factor,bump,3,30,0.16,100,0.25,5e-6,5e-3,0,0.3,,,,no amplitude gives it
"""


def test_the_headline_has_the_models_the_amplitudes_and_what_is_left_out(repository, tmp_path):
    (tmp_path / "models").mkdir()
    (tmp_path / "models/recommended.csv").write_text(RECOMMENDED)
    (tmp_path / "simulations/screen").mkdir(parents=True)
    (tmp_path / "simulations/screen/budget.csv").write_text(
        "h0_m,hv_m,left_out_least_percent,left_out_most_percent,above_range,basis\n"
        "5e-6,1e-6,-1.2,0.5,,this scene\n6e-6,1e-6,-2,11,inertia,this scene\n"
    )
    results = Results.of(tmp_path, repository / "config/plate.yaml")
    text = render("in_short.md", **headline_values(results))
    assert (
        "limit_1, 0.9 % off over 32 points of the validation sample, at one of all 48 simulations "
        "there 3 %\n" in text
    )
    assert "25 %. No model compared holds the study's ±15 %" in text
    assert "| limit_1 | 0 | 0 | 1.33 | 6.3 % |" in text
    assert "| bump | 5 | 0 | none | no amplitude gives it |" in text
    assert "by −2 to +11 % in all (first order and what higher ones may add; somewhere" in text
    empty = "space,model,validation_error,force_n\n,,,\n"
    (tmp_path / "models/recommended.csv").write_text(empty)
    assert "No model compared can be judged" in render("in_short.md", **headline_values(results))
    levitation = Results(tmp_path, load_config(repository / "config/levitation.yaml"))
    assert "- Beyond Re 10" in render("in_short.md", **headline_values(levitation))


def test_the_report_begins_with_the_headline_and_pictures(tmp_path):
    (tmp_path / "a.png").write_bytes(b"picture")
    headline = "- F = {{ 1 }} N <b>\n"
    for guide in ("paper_guide.rst", "study_guide.rst"):
        page = front_page(headline, study="<a>", pictures=[tmp_path / "a.png"], guide=guide)
        raw, _, rest = page.partition("{% endraw %}")
        assert raw.startswith("{% raw %}")
        assert "<h1>Study “&lt;a&gt;”</h1>" in raw
        assert "<li>F = {{ 1 }} N &lt;b&gt;</li>" in raw
        assert "data:image/png;base64,cGljdHVyZQ==" in raw
        # A line that is not indented would end what is raw.
        assert not re.search(r"^\S", raw.partition(".. raw:: html\n")[2], re.MULTILINE)
        assert "surface lift" in rest
    with pytest.raises(InputError, match=r"b\.png"):
        front_page(headline, study="a", pictures=[tmp_path / "b.png"], guide=guide)


def test_cells_of_a_table_cannot_end_it():
    text = render("claims.md", agreeing=1, claims=pd.DataFrame({"claim_id": [1], "claim": ["a|b"]}))
    assert "| a\\|b |" in text

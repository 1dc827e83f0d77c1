"""Pages: tables stay tables, nothing is taken for code, and the summary tells what it must."""

import json
import re

import pytest

from reporting.pages.headline import in_short
from reporting.pages.notes import Inertia
from reporting.pages.page import to_html
from reporting.pages.summary import to_markdown
from squeezefilm.cli import main as cli
from squeezefilm.config.loading import load_config


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


def test_pages_are_made_by_the_command(tmp_path, refused):
    (tmp_path / "a.md").write_text("**a**", encoding="utf-8")
    names = [str(tmp_path / name) for name in ("a.md", "a.html", "none.md", "none.html")]
    assert cli.main(["pages", names[0], "--output", names[1]]) == 0
    assert "<strong>a</strong>" in (tmp_path / "a.html").read_text(encoding="utf-8")
    assert cli.main(["pages", names[2], "--output", names[3]]) == 2
    assert "none.md" in refused("pages", names[0], names[2], "--output", names[1])


@pytest.fixture
def summary(study, tmp_path):
    plans = ("screen", "two_factor_design", "error_map", "extrapolation", "four_factor")
    fits = ("screen", "two_factor_design", "four_factor_design")
    pairs = [("two_factor_design", "screen"), ("four_factor_design", "four_factor")]
    claims = [f"--output={tmp_path}/claims.csv", f"--markdown={tmp_path}/claims.md"]
    assert cli.main(["claims", *study.words(study.claims), *claims]) == 0
    return to_markdown(
        study="paper",
        settings=load_config(study.config),
        forces={plan: study.root / f"simulations/{plan}/forces.csv" for plan in plans},
        fits={fit: study.root / f"fits/{fit}.json" for fit in fits},
        validations={
            (fit, plan): study.root / f"validation/{fit}_on_{plan}.json" for fit, plan in pairs
        },
        notes={"h0 = 5 µm": ["inertia, left out"], "h0 = 10 µm": []},
        claims=tmp_path / "claims.csv",
        device=study.root / "simulations/device.json",
    )


def test_the_summary_says_what_how_accurate_and_where_it_differs(summary):
    assert "43.27 kHz" in summary
    assert "Made were 193 simulations" in summary
    assert "| screen | 60 | 5 – 10 | 0.2 – 2 | 0 | 0 | 0.00183 – 0.784 | 3e-7 |" in summary
    assert "| gas: viscosity_pa_s | 1.81e-05 |" in summary
    assert "the largest estimated error of all forces is 3e-7 of the force" in summary
    assert "| two_factor_design (5 points) | screen (60 points) | 0.98" in summary
    assert "Of 22 claims of the paper" in summary
    differing = summary.split("## Where it differs")[1]
    assert "| global error of the fit on the screen | 3 | 0.53" in differing
    assert "differs because our" not in differing
    assert "agrees" not in differing.split("\n|", 1)[1]


def test_the_summary_of_another_actuator_does_not_speak_of_the_paper_s(study, summary):
    """Its claims, and that the study re-makes it; what is left out and the scan are said."""
    fit = json.loads((study.root / "fits/screen.json").read_text())
    path = study.root / "fits/scanned.json"
    path.write_text(json.dumps(fit | {"profile_uncertainty": 0.016}))
    settings = dict(load_config(study.config).sections)
    settings["actuator"] = settings["actuator"] | {"profile": {"kind": "measured"}}
    own = to_markdown(
        study="plate",
        settings=settings,
        forces={"screen": study.root / "simulations/screen/forces.csv"},
        fits={"screen": path},
        validations={("screen", "screen"): study.root / "validation/screen_on_screen.json"},
        notes={"h0 = 15 µm": ["inertia, left out, adds about 10% of the force"]},
        claims=None,
        device=study.root / "simulations/device.json",
    )
    assert "It re-makes" in summary
    assert "It re-makes" not in own
    assert "claims" not in own
    assert "paper" not in own
    assert "At h0 = 15 µm: inertia, left out, adds about 10% of the force" in own
    assert "leave up to 1.6 % of a force open" in own


def test_pages_of_a_film_beyond_re_10_say_so_below_their_title(repository, tmp_path):
    (tmp_path / "a.md").write_text("# Models\n\nA table.\n", encoding="utf-8")
    said = {}
    for name in ("levitation", "plate"):
        words = ["--config", str(repository / f"config/{name}.yaml")]
        page = tmp_path / f"{name}.html"
        assert cli.main(["pages", str(tmp_path / "a.md"), "--output", str(page), *words]) == 0
        said[name] = page.read_text(encoding="utf-8")
    assert "<p><strong>Beyond Re 10: the modified Reynolds number" in said["levitation"]
    assert said["levitation"].index("<h1>Models") < said["levitation"].index("Beyond Re 10")
    assert "Beyond Re" not in said["plate"]
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
        "left_out_least_percent,left_out_most_percent,above_range,basis\n"
        "-1.2,0.5,,this scene\n-2,11,inertia,this scene\n"
    )
    config = load_config(repository / "config/plate.yaml")
    text = "\n".join(in_short(tmp_path, config))
    assert (
        "limit_1, 0.9 % off over 32 points of the validation sample, at one of all 48 simulations "
        "there 3 %\n" in text
    )
    assert "25 %. No model compared holds the study's ±15 %" in text
    assert "| limit_1 | 0 | 0 | 1.33 | 6.3 % |" in text
    assert "| bump | 5 | 0 | none | no amplitude gives it |" in text
    assert "by −2 to +11 % in all (first order and what higher ones may add; somewhere" in text
    (tmp_path / "models/recommended.csv").write_text("space,model,validation_error,force_n\n,,,\n")
    assert "No model compared can be judged" in "\n".join(in_short(tmp_path, config))
    levitation = load_config(repository / "config/levitation.yaml")
    assert "Beyond Re 10" in "\n".join(in_short(tmp_path, levitation))


@pytest.mark.parametrize(
    ("command", "guide"),
    [
        ("front", "the surface lift the finger?"),
        ("paper-front", "an ultrasonic surface lift a finger?"),
    ],
)
def test_the_report_begins_with_the_headline_and_pictures(tmp_path, command, guide):
    summary = "# Study “a” on one page\n\n## In short\n\n- F = {{ 1 }} N\n\n## More\n\nx\n"
    (tmp_path / "summary.md").write_text(summary, encoding="utf-8")
    (tmp_path / "a.png").write_bytes(b"picture")
    words = ["--pictures", f"{tmp_path}/a.png"]
    target = tmp_path / "front.rst"
    assert cli.main([command, f"{tmp_path}/summary.md", *words, "--output", str(target)]) == 0
    page = target.read_text(encoding="utf-8")
    raw, _, rest = page.partition("{% endraw %}")
    assert raw.startswith("{% raw %}")
    assert "<li>F = {{ 1 }} N</li>" in raw
    assert "data:image/png;base64,cGljdHVyZQ==" in raw
    assert "More" not in raw
    assert guide in rest

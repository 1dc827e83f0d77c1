"""Write the explorer: one HTML file in which the fitted models can be played with.

  squeezefilm explorer FIT.json ... --forces PLAN=FORCES.csv ... --config C --output explorer.html

A fit bears the name of its file, which is that of the plan it was fitted on; the first one given
is shown first. The forces are what the models are judged by. The page needs no network.
"""

import argparse
from pathlib import Path

from reporting.explorer import Study, explorer_page
from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import load_config

SECTIONS = ("study", "extrapolation", "validation")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fits", nargs="+", metavar="FIT.json", help="fitted models")
    parser.add_argument("--forces", nargs="+", required=True, metavar="PLAN=FORCES.csv")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="EXPLORER.html", help="page to write")


def run(options: argparse.Namespace) -> None:
    from plotly.offline import get_plotlyjs  # slow to import

    config = load_config(options.config).only(SECTIONS)
    fits = {Path(path).stem: read_fit(path) for path in options.fits}
    if len(fits) < len(options.fits):
        raise InputError("explorer: two fits bear the same name")
    plans = [word.partition("=")[0] for word in options.forces]
    paths = parse_sources(options.forces, names=plans, user="explorer")
    study = Study(
        name=config["study"],
        fits=fits,
        forces={plan: read_ok_forces(path) for plan, path in paths.items()},
        force_n=config["extrapolation"]["force_n"],
        h0_m=config["extrapolation"]["h0_m"],
        hv_m=config["extrapolation"]["hv_m"],
        band=config["validation"]["relative_error_band"],
    )
    page = explorer_page(study, drawing_library=get_plotlyjs())
    write_text(page, options.output)

"""Write the explorer: one HTML file in which the fitted models can be played with.

  squeezefilm explorer FIT.json ... --forces PLAN=FORCES.csv ... --config C --output explorer.html

The first fit given is shown first; one that was refused is named with the reason. The forces are
drawn beside the models, and must have those that each was fitted to. --modulation takes the
tables of `squeezefilm response` for a plan of the centred finger. The page needs no network.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from reporting.explorer import Study, explorer_page
from reporting.explorer.modulation import modulation
from reporting.pages.notes import Inertia
from squeezefilm.config.loading import load_config
from squeezefilm.io.atomic import digest, write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import parse_sources, read_columns
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fitted import FittedModel, read_fit


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fits", nargs="+", metavar="FIT.json", help="fitted models")
    parser.add_argument("--forces", nargs="+", required=True, metavar="PLAN=FORCES.csv")
    parser.add_argument("--modulation", nargs=2, metavar=("RESPONSE.csv", "GAINS.csv"))
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="EXPLORER.html", help="page to write")


def run(options: argparse.Namespace) -> None:
    from plotly.offline import get_plotlyjs  # slow to import

    config = load_config(options.config)
    plans = [word.partition("=")[0] for word in options.forces]
    paths = parse_sources(options.forces, names=plans, user="explorer")
    fits, fitted_on, left_out = _named(options.fits, paths)
    study = Study(
        name=config["study"],
        fits=fits,
        plans=fitted_on,
        forces={plan: read_ok_forces(path) for plan, path in paths.items()},
        force_n=config["extrapolation"]["force_n"],
        h0_m=config["extrapolation"]["h0_m"],
        hv_m=config["extrapolation"]["hv_m"],
        inertia=Inertia.of(config),
        modulation=_modulation(*options.modulation) if options.modulation else None,
        left_out=left_out,
    )
    page = explorer_page(study, drawing_library=get_plotlyjs())
    write_text(page, options.output)


def _modulation(response: str, gains: str) -> dict[str, Any]:
    films = read_columns(response, columns=("h0_m", "hv_m", "status"))
    rows = read_columns(gains, columns=("h0_m", "hv_m", "frequency_hz", "gain", "error"))
    return modulation(films, rows)


def _named(
    files: Sequence[str], forces: Mapping[str, Path]
) -> tuple[dict[str, FittedModel], dict[str, str], dict[str, str]]:
    """The fits and their plans, by names that differ, and why models were refused, by theirs.

    A fit is called as its file, which a plan's fit shares with the plan; another has the plan's
    name beside its own.
    """
    plan_of = {digest(Path(path)): plan for plan, path in forces.items()}
    fits: dict[str, FittedModel] = {}
    plans, left_out = {}, {}
    for file in files:
        values, stem = read_json(file), Path(file).stem
        if "refused" in values:
            left_out[str(values.get("model", stem))] = str(values["refused"])
            continue
        source = values.get("source")
        known = source.get("forces_sha256") if isinstance(source, dict) else None
        plan = plan_of.get(str(known), stem)
        name = stem if stem == plan else f"{stem} on {plan}"
        if name in fits:
            raise InputError(f"explorer: two fits bear the same name, {name}")
        fits[name], plans[name] = read_fit(file), plan
    return fits, plans, left_out

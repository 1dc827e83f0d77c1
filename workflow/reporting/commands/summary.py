"""Put a finished study on one page: what was simulated, how accurate, where it differs.

  squeezefilm summary RESULTS --config C.yaml --forces screen … --fits screen … \\
      --validations screen_on_screen … --output SUMMARY.md

RESULTS is the study's folder; the plans, fits and validations are named as the files in it are.
"""

import argparse
from pathlib import Path

from reporting.pages.headline import in_short
from reporting.pages.summary import to_markdown
from squeezefilm.film.validity import exceeded
from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import ScenePoint
from squeezefilm.quantities.model_error import error_budgets, excluded_terms, notes_of_budget
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.terms import notes_of
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.studies.study import scene_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--forces", nargs="+", required=True, metavar="PLAN")
    parser.add_argument("--fits", nargs="+", required=True, metavar="FIT")
    parser.add_argument("--validations", nargs="+", required=True, metavar="FIT_on_PLAN")
    parser.add_argument("--output", required=True, metavar="SUMMARY.md")


def run(options: argparse.Namespace) -> None:
    results: Path = options.results
    config = load_config(options.config)
    text = to_markdown(
        study=results.resolve().name,
        settings=config,
        forces={plan: results / "simulations" / plan / "forces.csv" for plan in options.forces},
        fits={fit: results / "fits" / f"{fit}.json" for fit in options.fits},
        validations={
            _pair(name): results / "validation" / f"{name}.json" for name in options.validations
        },
        notes=_notes(config),
        claims=results / "claims.csv" if config["paper"] else None,
        device=results / "simulations" / "device.json",
        headline=in_short(results, config),
    )
    write_text(text, options.output)


def _notes(config: Config) -> dict[str, list[str]]:
    """What the equation leaves out at the screen's smallest and largest gap, the finger centred.

    Of the scenes as they were solved, with inertia where it was decided to be in.
    """
    levels, amplitude = config["screen"]["h0_m"], config["screen"]["hv_m"]["stop"]
    gaps = (levels["start"], levels["stop"])
    scenes = [scene_of(ScenePoint("1", gap, amplitude), config) for gap in gaps]
    settings, device = (
        solver_settings(config, outputs=()),
        choose_device(config["solver"]["device"]),
    )
    out = [excluded_terms(scene, method=settings.method) for scene in scenes]
    scenes = settings.resolved(scenes, device)
    found = error_budgets(scenes, device=device)
    return {
        f"h0 = {1e6 * gap:g} µm": [
            *names,
            *exceeded(scene),
            *notes_of_budget(budget),
            *notes_of(scene),
        ]
        for gap, names, scene, budget in zip(gaps, out, scenes, found, strict=True)
    }


def _pair(name: str) -> tuple[str, str]:
    fit, on, plan = name.partition("_on_")
    if not on:
        raise InputError(f"--validations: {name!r} is not FIT_on_PLAN")
    return fit, plan

"""Data of the overview: what the whole study does, from a simulation to the error of a model."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, model_mesh, plane_table
from reporting.figure_data.errors import error_table
from reporting.pages.notes import percent, rounded_up
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fitted import number, read_fit
from squeezefilm.studies.config import Config

INPUTS = (
    "film",
    "film_forces",
    "forces",
    "fit",
    "design_forces",
    "errors",
    "validation",
)
SECTIONS: tuple[str, ...] = ()

FILM_COLUMNS = ("phase_deg", "x_mm", "surface_um", "finger_um", "overpressure_kpa")


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers film, model, simulation, design and map, and four captions in column text."""
    film = read_columns(inputs["film"], columns=("point_id", *FILM_COLUMNS))
    point = film["point_id"].iloc[0]
    forces, fit = read_ok_forces(inputs["forces"]), read_fit(inputs["fit"])
    simulated = read_ok_forces(inputs["film_forces"]).set_index("point_id").loc[point]
    design = read_ok_forces(inputs["design_forces"])
    summary = read_json(inputs["validation"])
    worst, points = (
        number(summary, key, inputs["validation"]) for key in ("worst_relative_error", "points")
    )
    force_n, error_n = float(simulated["force_n"]), float(simulated["force_error_n"])
    captions = (
        f"{force_n:.3f} N, good to {rounded_up(error_n / force_n + fit.scan_error)} of it",
        f"{len(forces)} simulations, error {percent(fit.global_error)}",
        f"{len(design)} points instead of {len(forces)}",
        f"{points:.0f} more: at most {percent(abs(worst))} off",
    )
    data = pd.concat(
        [
            film.loc[film["point_id"] == point, list(FILM_COLUMNS)].assign(layer="film"),
            model_mesh(fit, forces),
            plane_table(forces, layer="simulation"),
            plane_table(design, layer="design"),
            error_table(inputs["errors"], inputs["validation"], layer="map"),
            pd.DataFrame({"layer": "caption", "text": captions}),
        ],
        ignore_index=True,
    )
    estimate = rounded_up(float((forces["force_error_n"] / forces["force_n"]).max()))
    scan = f", of the scan up to {percent(fit.scan_error)}" if fit.scan_error else ""
    seen = f"at {film['phase_deg'].nunique()} times of a period (red: surface up)"
    if film["overpressure_kpa"].notna().all():  # where there is a state to show (cross_section)
        seen = f"its pressure {seen} and their mean (thick)"
    note = (
        f"From left to right: a film at h0 = {1e6 * simulated['h0_m']:g} µm, "
        f"hv = {1e6 * simulated['hv_m']:g} µm, "
        f"{seen}; the model fitted to the screen; the "
        "D-optimal points beside the screen's; the error of the model fitted to them alone. "
        f"Estimated error of the simulations ≤ {estimate} of the force{scan}."
    )
    return data.assign(note=note)

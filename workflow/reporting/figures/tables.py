"""What several figures' tables are built with: units, limits, the model on a mesh, errors."""

import numpy as np
import pandas as pd

from reporting.notes import percent
from reporting.results import Results
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel

MESH_LINES = 26
"""Lines of a model's mesh along each factor."""


def plane_table(table: pd.DataFrame, *, layer: str) -> pd.DataFrame:
    """Gap and amplitude of a table of scenes in µm, with the force in N where it is known."""
    columns = ["layer", "h0_um", "hv_um", *(["force_n"] if "force_n" in table else [])]
    return in_micrometres(table).assign(layer=layer)[columns].reset_index(drop=True)


def in_micrometres(table: pd.DataFrame) -> pd.DataFrame:
    """The table with gap and amplitude in µm, too."""
    return table.assign(h0_um=micrometres(table["h0_m"]), hv_um=micrometres(table["hv_m"]))


def micrometres(metres: pd.Series) -> np.ndarray:
    """Metres in µm, rounded so that 7e-6 becomes 7 and not 7.000000000000001."""
    return np.round(metres.to_numpy(dtype=float) * 1e6, 9)


def model_mesh(fit: FittedModel, screen: pd.DataFrame) -> pd.DataFrame:
    """The fitted force of a centred finger on a mesh over the experimental space."""
    h0_m = np.linspace(screen["h0_m"].min(), screen["h0_m"].max(), MESH_LINES)
    hv_m = np.linspace(screen["hv_m"].min(), screen["hv_m"].max(), MESH_LINES)
    gaps, amplitudes = (values.ravel() for values in np.meshgrid(h0_m, hv_m, indexing="ij"))
    force = fit.force_model.evaluate(fit.theta, Factors.of(h0_m=gaps, hv_m=amplitudes))
    return plane_table(
        pd.DataFrame({"h0_m": gaps, "hv_m": amplitudes, "force_n": force}), layer="model"
    )


def error_table(results: Results, fit: str, plan: str, *, layer: str) -> pd.DataFrame:
    """Relative error of a fit in percent at each point of a plan, and whether it is in the band."""
    points, band = results.errors(fit, plan), results.validation(fit, plan)["band"]
    return plane_table(points[["h0_m", "hv_m"]], layer=layer).assign(
        relative_error_percent=100 * points["relative_error"],
        in_band=points["relative_error"].abs() <= band,
        band_percent=100 * band,
    )


def error_note(results: Results, fit: str, plan: str) -> str:
    """The errors of a fit over the points of a plan."""
    errors = results.validation(fit, plan)
    return (
        f"{errors['points']:.0f} points: global error {percent(errors['global_error'])}, "
        f"largest {percent(errors['worst_relative_error'])}"
    )

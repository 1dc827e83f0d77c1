"""Measured forces beside computed ones, each kind of error apart."""

from typing import Any

from matplotlib.figure import Figure

from squeezefilm.film.validity import OK
from squeezefilm_workflow.reporting.figures import style
from squeezefilm_workflow.reporting.results import Results

MODELLING_ERROR_STYLE: dict[str, Any] = {"color": style.ORANGE, "linewidth": 4, "alpha": 0.5}
NUMERICAL_ERROR_STYLE: dict[str, Any] = {
    "color": "black",
    "fmt": "none",
    "capsize": 2.5,
    "elinewidth": 0.8,
}
MEASURED_STYLE: dict[str, Any] = {"color": style.BLUE, "fmt": "o", "ms": 3}


def measurements(results: Results) -> Figure:
    """Left measured over computed forces, right residuals beside the errors of computed ones."""
    data = results.table("measurements/comparison.csv", "residual_n", "status")
    data = data[data["status"] == OK]
    measured, force, residual = data["measured_force_n"], data["force_n"], 1e3 * data["residual_n"]
    bounds = [data[f"modelling_error_{end}_n"] for end in ("lower", "upper")]
    uncertainty = data["measurement_uncertainty_n"]
    error = data["force_error_n"] + data["profile_uncertainty_n"]
    figure, (left, right) = style.subplots(1, 2, wide=True, height_in=3.2)
    left.axline((0, 0), slope=1, color=style.GREY, linewidth=0.6)
    left.hlines(measured, *(force + each for each in bounds), **MODELLING_ERROR_STYLE)
    left.errorbar(force, measured, xerr=error, **NUMERICAL_ERROR_STYLE)
    left.errorbar(force, measured, uncertainty, **MEASURED_STYLE)
    left.set(ylabel="measured force (N)", title="(a) measured and computed")
    right.axhline(0, color=style.GREY, linewidth=0.6)
    right.vlines(
        force, *(1e3 * each for each in bounds), **MODELLING_ERROR_STYLE, label="modelling error"
    )
    right.errorbar(
        force, 0 * force, 1e3 * error, **NUMERICAL_ERROR_STYLE, label="numerical error, mode shape"
    )
    right.errorbar(
        force,
        residual,
        1e3 * uncertainty,
        **MEASURED_STYLE,
        label="measurement, ± standard uncertainty",
    )
    right.set(ylabel="measured − computed force (mN)", title="(b) residuals")
    figure.legend(*right.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    for panel in (left, right):
        panel.set_xlabel("computed force (N)")
        panel.grid(True)
    verdict = results.read_json_file("measurements/summary.json")["verdict"]
    style.add_note(figure, f"χ² test: {verdict}.", results.validity_note)
    return figure

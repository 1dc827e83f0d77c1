"""Published numbers beside exact solutions, and these beside the solver.

A row is one number. Its deviations are of the exact solution from what was published, of the solver
from the exact solution, and of the Reynolds equation without inertia and thermal effects from what
the exact solution is compared with: absolute values, relative, of complex numbers and fields too.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import product
from math import nan, pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.errors import RunError
from squeezefilm.film.pad import GapShape, Pad
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.quantities.outputs import with_outputs
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.terms.rarefaction import slip_flow
from squeezefilm_workflow.verification.films import PISTON_PROFILE, film_scene
from squeezefilm_workflow.verification.published import slider
from squeezefilm_workflow.verification.published.linear_film import (
    VISCOUS_FACTORS,
    depth_averaged_factors,
    disc_response,
    exact_factors,
    piston_response,
    radial_pressure,
)
from squeezefilm_workflow.verification.rarefied_flow import poiseuille_flow

PUBLISHED_FOLDER = Path(__file__).parent
SMALL_EPSILON = 1e-4
"""ε of a linear film: what is left of the next order is 2e-8 of the first harmonic."""
# ANSYS Mechanical APDL Verification Manual, VM245: damping in N s/m, stiffness in N/m.
PUBLISHED_DAMPING_N_S_PER_M, PUBLISHED_STIFFNESS_N_PER_M = 15.29e-3, 28.65e3
# Air of the finite elements (DisplacementPressure_Space.py): density, sound speed, viscosity, γ,
# heat capacity, conductivity, in SI units.
AIR_PROPERTIES = {"density": 1.18, "sound": 345.9, "viscosity": 1.83e-5, "gamma": 1.4}
AIR_PRESSURE_PA = AIR_PROPERTIES["density"] * AIR_PROPERTIES["sound"] ** 2 / AIR_PROPERTIES["gamma"]
AIR_PRANDTL = AIR_PROPERTIES["viscosity"] * 1005 / 24.4e-3
# Distances from the hole's edge, in gaps, at which the pressure is prescribed: flow around the
# edge, which no film equation has, has decayed at the second.
HOLE_DISTANCES_IN_GAPS, RADIAL_PRESSURE_LABEL = (0, 2), "p(r), given {} gaps from the hole"
REYNOLDS_VALUES, SIGMA_VALUES = (0.1, 1.0, 4.0, 10.0, 20.0, 40.0), (1.0, 10.0, 100.0, 1000.0)
SAMPLE_REYNOLDS_SIGMA_VALUES = (4.0,), (1.0, 100.0)
RESPONSE_FUNCTION_OF_SHAPE: dict[str, Any] = {
    "rectangle": piston_response,
    "ellipse": disc_response,
}
# Relative error of the solver's first harmonic against its own equation's.
HARMONIC_TOLERANCE = 1e-6
# github.com/cml-berkeley/cmlair, flow.f90: Poiseuille flow of the linearised Boltzmann equation by
# inverse Knudsen number, of the tables in comments.
PUBLISHED_RAREFIED_FLOW = {0.01: 3.060, 0.1: 2.033, 1.0: 1.539, 10.0: 2.768, 100.0: 17.693}
# github.com/hannes-holey/hans, tests/inclined-slider1D_x_ideal-gas.yaml; and two widths whose
# difference is free of the ends.
SLIDER_GAPS_M, SLIDER_LENGTH_M, SLIDER_WIDTHS_M = (66e-6, 10e-6), 0.1, (0.5, 1.0)


COMPARISON_COLUMNS = (
    *("source", "case", "quantity", "modified_reynolds", "sigma", "published", "exact", "solver"),
    *("exact_deviation", "solver_deviation", "viscous_deviation", "status"),
)

ComparisonRow = dict[str, Any]
"""One number: what it has of COMPARISON_COLUMNS."""


def comparison_table(*, sample: bool, device: Device | None = None) -> pd.DataFrame:
    """All comparisons; of depth averaging a small sample, if asked for."""
    reynolds, sigma = SAMPLE_REYNOLDS_SIGMA_VALUES if sample else (REYNOLDS_VALUES, SIGMA_VALUES)
    rows = [
        *compare_plate(device),
        *compare_inclined_slider(device),
        *compare_rarefied_flow(),
        *compare_radial_films(),
        *compare_depth_averaging(reynolds, sigma, device),
    ]
    return table_of_rows(rows)


def table_of_rows(rows: Iterable[ComparisonRow]) -> pd.DataFrame:
    """Rows as a table, NaN where a kind of value or deviation does not exist.

    Deviations are those of a row's numbers where nothing else is given. ``status`` is ``ok``, or
    why there is no value of the solver.
    """
    table = pd.DataFrame(rows, columns=list(COMPARISON_COLUMNS))
    own = {
        "exact_deviation": abs(table["exact"] / table["published"] - 1),
        "solver_deviation": abs(table["solver"] / table["exact"] - 1),
    }
    table = table.fillna(pd.DataFrame(own)).astype({"status": object})
    return table.fillna({"status": "ok"})


def compare_plate(device: Device | None = None) -> Iterator[ComparisonRow]:
    """Linear damping and stiffness of a plate of 2 mm by 1 mm over a gap of 5 µm at 100 kHz."""
    gas = Gas(viscosity_pa_s=18.3e-6, ambient_pressure_pa=1e5, inertia="none", thermal="none")
    pad, h0_m = Pad(2e-3, 1e-3, 0.0), 5e-6
    scene = Film(gas, Actuator(1e5, 1.0, profile=PISTON_PROFILE), pad).scene(
        h0_m, SMALL_EPSILON * h0_m
    )
    response = scene.force_scale_n / h0_m * piston_response(scene.sigma, scene.aspect)
    rate = scene.actuator.angular_frequency_rad_per_s
    (outputs,) = _solved_quantities([scene], "harmonics", tolerance=1e-6, device=device)
    row = partial(_comparison_row, source="ANSYS VM245", case="plate, 100 kHz", sigma=scene.sigma)
    yield row(
        "damping / (N s/m)",
        PUBLISHED_DAMPING_N_S_PER_M,
        response.imag / rate,
        outputs["film_damping"],
    )
    yield row(
        "stiffness / (N/m)", PUBLISHED_STIFFNESS_N_PER_M, response.real, outputs["film_stiffness"]
    )


def compare_inclined_slider(device: Device | None = None) -> Iterator[ComparisonRow]:
    """Largest pressure, load and centre of pressure of a wide slider with a gap ratio of 6.6."""
    (wide_m, narrow_m), length_m = SLIDER_GAPS_M, SLIDER_LENGTH_M
    gas = Gas(viscosity_pa_s=1.846e-5, inertia="none", thermal="none")
    pads = [Pad(length_m, w, 50.0, gap=GapShape(narrow_m - wide_m)) for w in SLIDER_WIDTHS_M]
    films = [Film(gas, Actuator(1e3, 1.0, profile=PISTON_PROFILE), pad) for pad in pads]
    scenes = [film.scene((wide_m + narrow_m) / 2, 0.0) for film in films]
    one, other = _solved_quantities(scenes, "moments", "extremes", tolerance=1e-7, device=device)
    p0_pa, force_n = gas.ambient_pressure_pa, other["force"] - one["force"]
    ours = (
        1 + other["gauge_pressure_max"] / p0_pa,
        force_n / (scenes[1].force_scale_n - scenes[0].force_scale_n),
        0.5 - (other["moment_y"] - one["moment_y"]) / force_n / length_m,
    )
    stored = pd.read_csv(PUBLISHED_FOLDER / "slider.csv", comment="#")
    cells = slider.slider_quantities_of_cells(
        stored["x"].to_numpy(), stored["pressure_pa"].to_numpy() / p0_pa
    )
    names = "largest pressure / p0", "load / (p0 area)", "centre of pressure / length"
    for numbers in zip(names, cells, slider.exact_slider_quantities(scenes[1]), ours, strict=True):
        yield _comparison_row(*numbers, source="hans (Holey)", case="inclined slider, Λ 54.66")


def compare_rarefied_flow() -> Iterator[ComparisonRow]:
    """Poiseuille flow of a rarefied gas; the solver's is what its flow factor interpolates."""
    row = partial(_comparison_row, "Poiseuille flow", source="cmlair (CML Berkeley)")
    for inverse, flow in PUBLISHED_RAREFIED_FLOW.items():
        ours = inverse / 6 + float(slip_flow(inverse))
        yield row(flow, poiseuille_flow(inverse), ours, case=f"rarefied gas, D {inverse:g}")


def compare_radial_films() -> Iterator[ComparisonRow]:
    """Pressure behind membranes and plates around a hole, their motion and one pressure given."""
    stored = pd.read_csv(PUBLISHED_FOLDER / "radial_films.csv", comment="#")
    for _, nodes in stored.groupby(["plate", "gap_m", "frequency_hz"]):
        kind, frequency_hz, hole_m, gap_m = nodes.iloc[0, :4]
        omega, viscosity = 2 * pi * frequency_hz, AIR_PROPERTIES["viscosity"]
        reynolds = AIR_PROPERTIES["density"] * omega * gap_m**2 / viscosity
        squeeze = 12 * viscosity * omega / (AIR_PRESSURE_PA * gap_m**2)
        resolved = exact_factors(
            reynolds, prandtl=AIR_PRANDTL, heat_capacity_ratio=AIR_PROPERTIES["gamma"]
        )
        for distance in HOLE_DISTANCES_IN_GAPS:
            away = nodes["r_m"] >= hole_m * (1 - 1e-9) + distance * gap_m
            r_m, xi_real, xi_imag, p_real, p_imag = nodes.loc[away, "r_m":].to_numpy().T
            pressure = (p_real + 1j * p_imag) / AIR_PRESSURE_PA
            motion = (xi_real + 1j * xi_imag) / gap_m
            pressures = [
                radial_pressure(r_m, motion, pressure[0], squeeze=squeeze, factors=factors)
                for factors in (resolved, VISCOUS_FACTORS)
            ]
            deviation = np.linalg.norm(np.array(pressures) - pressure, axis=1)
            deviation /= np.linalg.norm(pressure)
            yield dict(
                source="Honzík et al.",
                case=f"{kind}, {1e6 * gap_m:.0f} µm, {1e-3 * frequency_hz:.0f} kHz",
                quantity=RADIAL_PRESSURE_LABEL.format(distance),
                modified_reynolds=reynolds,
                exact_deviation=deviation[0],
                viscous_deviation=deviation[1],
            )


def compare_depth_averaging(
    reynolds: Sequence[float], sigma: Sequence[float], device: Device | None = None
) -> Iterator[ComparisonRow]:
    """First harmonic of a piston's force by the solver, with inertia, then thermal effects too.

    Of a square, then of a disc; without the solver's where that is not converged. Raises RunError
    where there is none for another reason, or one that is not that of the parabolic profiles.
    """
    for shape, thermal, re, s in product(
        RESPONSE_FUNCTION_OF_SHAPE, ("none", "included"), reynolds, sigma
    ):
        scene = film_scene("", SMALL_EPSILON, s, profile=PISTON_PROFILE, reynolds=re, shape=shape)
        scene = scene.with_gas(thermal=thermal)
        response = RESPONSE_FUNCTION_OF_SHAPE[shape]
        status = "ok"
        try:
            (outputs,) = _solved_quantities([scene], "harmonics", tolerance=1e-5, device=device)
        except RunError as error:
            status = str(error)
            if not status.startswith("not converged: "):
                raise
            outputs = {"force_in_phase": nan, "force_quadrature": nan}
        force = -(outputs["force_in_phase"] + 1j * outputs["force_quadrature"])
        ours = force / (scene.force_scale_n * scene.epsilon)
        prandtl = scene.gas.prandtl if thermal == "included" else 0.0
        gas = {"prandtl": prandtl, "heat_capacity_ratio": scene.gas.heat_capacity_ratio}
        parabolic = response(s, factors=depth_averaged_factors(re, **gas))
        if abs(ours / parabolic - 1) >= HARMONIC_TOLERANCE:
            raise RunError(f"first harmonic at Re {re:g}, σ {s:g}: {ours:.9g}, not {parabolic:.9g}")
        resolved = response(s, factors=exact_factors(re, **gas))
        yield dict(
            source="depth averaging",
            case="disc: " * (shape == "ellipse")
            + ("inertia and thermal effects" if thermal == "included" else "inertia"),
            quantity="first harmonic",
            modified_reynolds=re,
            sigma=s,
            exact=abs(resolved),
            solver=abs(ours),
            solver_deviation=abs(ours / resolved - 1),
            viscous_deviation=abs(response(s) / resolved - 1),
            status=status,
        )


def _comparison_row(
    quantity: str, published: float, exact: float, solver: float, **row: Any
) -> ComparisonRow:
    return dict(quantity=quantity, published=published, exact=exact, solver=solver, **row)


def _solved_quantities(
    scenes: Sequence[Scene], *outputs: str, tolerance: float, device: Device | None
) -> list[dict[str, float]]:
    """The mean force, ``force``, and outputs of each scene; raises RunError where there is none."""
    solutions = with_outputs(
        scenes,
        solve(scenes, tolerance=tolerance, method="periodic", device=device, keep_states=True),
        outputs=outputs,
        tolerance=tolerance,
        device=device,
    )
    values = []
    for solution in solutions:
        assert solution.outputs
        reasons = dict.fromkeys([solution.status, *solution.outputs.missing.values()])
        if [*reasons] != ["ok"]:
            raise RunError("; ".join(reason for reason in reasons if reason != "ok"))
        values.append({"force": solution.force_n, **solution.outputs.value})
    return values

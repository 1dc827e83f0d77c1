"""A study on one page: what was simulated, how accurate it is; the paper's, where it differs."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from reporting.pages.notes import percent, rounded_up
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.positions import POLAR, form_of
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fit_file import number, read_fit

PURPOSES = {
    "screen": "finger centred, gap and amplitude on a grid: the first fit",
    "two_factor_design": "the few points that teach most about the two-factor model",
    "error_map": "control points on another grid over the screen's ranges",
    "extrapolation": "a chosen point, and where the models expect the wanted force",
    "four_factor": "the two-factor design at every position of the finger",
    "four_factor_control": "random control points in all four factors",
    "four_factor_design": "the few points that teach most about the four-factor model",
    "four_factor_design_distinct": "the same, with points kept physically distinct",
}

POSITIONS = {
    "phi_r_m": ("φr (mm)", 1e3),
    "phi_deg": ("φφ (°)", 1.0),
    "x_m": ("x (mm)", 1e3),
    "y_m": ("y (mm)", 1e3),
}

NOTHING = 1e-3
"""Share of a range's largest value below which its least is as good as 0."""

INTRODUCTION = (
    "It re-makes, with other settings where they are named below, Winter, Markovic and Perriard, "
    "*Empirical Modeling of a Squeeze Film Haptic Actuator*, IEEE Trans. Ind. Appl. 50(3), 2014.\n"
)


def to_markdown(
    *,
    study: str,
    settings: Mapping[str, Any],
    forces: Mapping[str, Path],
    fits: Mapping[str, Path],
    validations: Mapping[tuple[str, str], Path],
    notes: Mapping[str, Sequence[str]],
    claims: Path | None,
    device: Path,
    headline: Sequence[str] = (),
) -> str:
    """The page, from finished results.

    ``forces`` and ``fits`` are by plan, ``validations`` by fit and plan; ``settings`` has the
    sections gas, actuator, finger and solver, ``notes`` what is left out at which gap, in words;
    ``claims`` are those of the paper, in its studies; ``headline`` are the lines it begins with.
    Raises InputError for a result that is missing or lacks what it must have.
    """
    tables = {plan: read_ok_forces(path) for plan, path in forces.items()}
    return "\n".join(
        [
            f"# Study “{study}” on one page\n",
            *headline,
            *([INTRODUCTION] if claims else []),
            *_simulated(settings, tables),
            *_accuracy(settings, tables, fits, validations, read_json(device)),
            *_left_out(notes),
            *(_differences(claims) if claims else ()),
        ]
    )


def _terms(gas: Mapping[str, Any], tables: Iterable[pd.DataFrame]) -> str:
    """What the study's equation has beyond the paper's: as the simulations had it, if any did."""
    words = {"included": "", "auto": " where it matters"}
    without = [row.split("; ") for table in tables for row in table["left_out"].dropna()]
    named = [
        f"{name}{words[gas[name]]}"
        for name in ("inertia", "heat")
        if gas[name] in words and not all(name in left_out for left_out in without)
    ]
    return f", with {' and '.join(named)}" if named else ""


def _simulated(settings: Mapping[str, Any], tables: Mapping[str, pd.DataFrame]) -> Iterator[str]:
    total = sum(len(table) for table in tables.values())
    frequency = settings["actuator"]["frequency_hz"] / 1e3
    gas = _terms(settings["gas"], tables.values())
    polar = form_of(next(iter(tables.values()))) == POLAR
    place = "radius φr and angle φφ" if polar else "x and y from the centre of the surface"
    yield "## What was simulated\n"
    yield (
        f"A plate vibrates at {frequency:g} kHz under a finger. The thin film of air between the "
        f"two is squeezed and stretched; it follows the compressible Reynolds equation{gas}, "
        "and once it has settled its mean pressure is above that of the room: the finger is "
        "lifted. The result of a simulation is this mean lifting force F. Its factors are the mean "
        "gap h0, the amplitude of vibration hv at its maximum, and where the finger is: "
        f"{place}. Made were {total} simulations, in these plans:\n"
    )
    yield markdown_table(pd.DataFrame([_plan(plan, table) for plan, table in tables.items()]))
    yield (
        "To the forces a short formula is fitted (the empirical models of Winter, Markovic and "
        "Perriard, 2014, with two and with four factors), once to a full plan and once to the "
        "few points of a D-optimal design. The question is how much worse the few points do.\n"
    )
    yield "What the simulations take as given:\n"
    given = [
        (name, value)
        for section in ("gas", "actuator", "finger", "solver")
        for name, value in _leaves(section, settings[section])
    ]
    yield markdown_table(pd.DataFrame(given, columns=["setting", "value"]))


def _plan(plan: str, table: pd.DataFrame) -> dict[str, str]:
    return {
        "plan": plan,
        "simulations": str(len(table)),
        "h0 (µm)": _range(1e6 * table["h0_m"]),
        "hv (µm)": _range(1e6 * table["hv_m"]),
        **{
            name: _range(scale * table[column])
            for column, (name, scale) in POSITIONS.items()
            if column in form_of(table)
        },
        "F (N)": _range(table["force_n"]),
        "largest estimated error of F": rounded_up(_largest_error(table)),
        "what for": PURPOSES.get(plan, ""),
    }


def _accuracy(
    settings: Mapping[str, Any],
    tables: Mapping[str, pd.DataFrame],
    fits: Mapping[str, Path],
    validations: Mapping[tuple[str, str], Path],
    device: Mapping[str, Any],
) -> Iterator[str]:
    largest = max(_largest_error(table) for table in tables.values())
    methods = sorted({method for table in tables.values() for method in table["method"]})
    yield "## How accurate it is\n"
    yield (
        f"*Simulations.* Asked for a relative error of {settings['solver']['tolerance']:g}; the "
        f"largest estimated error of all forces is {rounded_up(largest)} of the force. A "
        "periodic state is solved on several grids, whose differences are its estimate; a "
        "limit estimates what it leaves out. Method: "
        f"{', '.join(methods)}; double precision; device: {device.get('device', 'unknown')}. "
        "Where the numerics have been made, tables and pictures in this report compare the solver "
        "with other people's methods, and on stiff and extreme films.\n"
    )
    if settings["actuator"]["profile"]["kind"] == "measured":
        share = max(read_fit(path).profile_uncertainty for path in fits.values())
        yield (
            "*The scan.* The profile was measured. Its noise, and motion out of phase that is left "
            f"out, leave up to {percent(share)} of a force open: the measured profile's figure "
            "and `profile/forces.csv` say where. The errors above and in the tables of forces are "
            "the solver's alone, those below the models' beside simulations with the same profile: "
            "the scan's part adds to both. `squeezefilm predict`, `working-point` and the explorer "
            "contain it.\n"
        )
    yield (
        "*Models.* The global error is |model − simulation| over |simulation|, norms over all "
        "points of a plan; the worst is the largest relative error of a single point.\n"
    )
    yield markdown_table(
        pd.DataFrame(
            [_model(fit, plan, fits[fit], path) for (fit, plan), path in validations.items()]
        )
    )


def _model(fit: str, plan: str, fit_path: Path, path: Path) -> dict[str, str]:
    summary = read_json(path)
    worst = number(summary, "worst_relative_error", path)
    return {
        "model fitted on": f"{fit} ({read_fit(fit_path).points} points)",
        "judged on": f"{plan} ({number(summary, 'points', path):g} points)",
        "global error": percent(number(summary, "global_error", path)),
        "worst": percent(worst),
        "within the band": (
            f"{100 * number(summary, 'share_within_band', path):.3g} % within "
            f"±{100 * number(summary, 'band', path):g} %"
        ),
    }


def _left_out(notes: Mapping[str, Sequence[str]]) -> Iterator[str]:
    said = [f"At {gap}: {'; '.join(each)}." for gap, each in notes.items() if each]
    if said:
        yield (
            "*The equation.* What it leaves out is in none of these errors. Estimated at the "
            f"largest amplitude of the screen. {' '.join(said)}\n"
        )


def _differences(path: Path) -> Iterator[str]:
    claims = read_columns(path, columns=("claim", "paper", "ours", "verdict"))
    differs = claims["verdict"].str.startswith("differs")
    yield "## Where it differs from the paper\n"
    yield (
        f"Of {len(claims)} claims of the paper {int((~differs).sum())} agree with these results "
        "and these differ (the page of claims has them all, with explanations):\n"
    )
    columns = ["claim", "paper", "ours", "unit", "verdict"]
    shown = claims.loc[differs, columns]
    shown["verdict"] = shown["verdict"].str.removeprefix("differs because ")
    yield markdown_table(shown.rename(columns={"verdict": "differs because"}))
    yield (
        "Nothing was tuned to agree. The paper states neither the viscosity nor the pressure of "
        "the air, its tables and its measured amplitudes are not legible to us, and where a plan "
        "had to be read off a figure, the figure's caption says so.\n"
    )


def _largest_error(table: pd.DataFrame) -> float:
    return float((table["force_error_n"] / table["force_n"].abs()).max())


def _range(column: pd.Series) -> str:
    """From the least to the largest; what is nothing beside the largest is 0."""
    low, high = float(column.min()), float(column.max())
    low = 0.0 if abs(low) < NOTHING * abs(high) else low
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} – {high:.3g}"


def _leaves(place: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(f"{place}: {key}", inner)
    elif isinstance(value, Sequence) and not isinstance(value, str):
        yield place, ", ".join(map(str, value))
    else:
        yield place, f"{value:g}" if isinstance(value, float) else str(value)

"""Words below figures and tables: how the simulations were made and how accurate they are."""

import math
from pathlib import Path

import pandas as pd

from squeezefilm.io.tables import read_json


def simulations_note(device: Path, *tables: pd.DataFrame) -> str:
    """How and on what the simulations were made, and their largest error estimate, rounded up.

    ``tables`` are tables of forces, ``device`` describes the OpenCL device.
    """
    forces = pd.concat(tables)
    name = read_json(device).get("device", "a device of unknown name")
    largest = float((forces["force_error_n"] / forces["force_n"].abs()).max())
    methods = ", ".join(sorted(set(forces["method"])))
    return (
        f"Simulations: {methods} state in double precision on {name}; estimated error "
        f"≤ {rounded_up(largest)} of the force."
    )


def percent(share: float) -> str:
    """A share as a percentage with three digits: 0.00533 → 0.533 %."""
    return f"{100 * share:.3g} %".replace("-", "−")


def one_digit(value: float) -> str:
    """A small number with one digit: 5.2e-06 → 5e-6."""
    mantissa, _, exponent = f"{value:.0e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


def rounded_up(value: float) -> str:
    """The next number with one digit that is not below a positive value: 2.1e-7 → 3e-7."""
    if value <= 0:
        return "0"
    exponent = math.floor(math.log10(value))
    digit = math.ceil(round(value / 10.0**exponent, 6))
    return one_digit(digit * 10.0**exponent)


def scan_note(scan_error: float) -> str:
    """What errors beside simulations do not show, where the profile was measured."""
    if not scan_error:
        return ""
    return (
        "The profile was measured, and models and simulations share it: what its scan leaves open, "
        f"up to {percent(scan_error)} of a force, adds to every error here.\n\n"
    )

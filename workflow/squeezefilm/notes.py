"""Words below figures and tables: how the simulations were made and how accurate they are."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd

from squeezefilm.tables import read_json


def simulations_note(device: Path, *tables: pd.DataFrame) -> str:
    """How and on what the simulations were made, and their largest error estimate, rounded up.

    ``tables`` are tables of forces, ``device`` describes the OpenCL device.
    """
    forces = pd.concat(tables)
    name = read_json(device).get("device", "a device of unknown name")
    largest = float((forces["force_error_n"] / forces["force_n"].abs()).max())
    exponent = math.floor(math.log10(largest)) if largest > 0 else 0
    digit = math.ceil(round(largest / 10.0**exponent, 6))
    methods = ", ".join(sorted(set(forces["method"])))
    return (
        f"Simulations: {methods} state in double precision on {name}; estimated error "
        f"≤ {digit}e{exponent} of the force."
    )


def percent(share: float) -> str:
    """A share as a percentage with three digits: 0.00533 → 0.533 %."""
    return f"{100 * share:.3g} %"

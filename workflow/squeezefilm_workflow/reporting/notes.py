"""Numbers as pages and figures show them, and how far a study's films go beyond its equation."""

import math
import re
from typing import Any

import pandas as pd

from squeezefilm import units
from squeezefilm.config.study import Study
from squeezefilm.film.validity import VALIDITY_LIMITS, ValidityLimit

CLAIM_COLUMNS_SHOWN = ("claim", "verdict", "paper", "ours", "unit")
"""Columns of claims in a summary; ``kind`` is a column of the table too."""


def claim_verdict_counts(claims: pd.DataFrame) -> dict[str, Any]:
    """Return a sentence that counts the paper's claims, and those that do not agree.

    Results are counted apart from settings: a setting agrees because a study takes it over.
    """
    shown, verdict = claims[list(CLAIM_COLUMNS_SHOWN)], claims["verdict"].str
    differing, undecided = (shown[verdict.startswith(word)] for word in ("differs", "undecided"))
    agree, result = verdict.startswith("agrees"), claims["kind"] == "result"
    small = int(result[undecided.index].sum())
    count = (
        f"{(agree & result).sum()} of {result.sum() - small} results of the paper agree; "
        f"{(agree & ~result).sum()} of {(~result).sum()} settings are the paper's"
    )
    if small:
        count += f". The study is too small to decide the other {small} results"
    return {"count": count, "differing": differing, "undecided": undecided}


def percent_text(fraction: float) -> str:
    """A fraction as a percentage with three digits: 0.00533 → 0.533 %."""
    digits = ".3g" if abs(fraction) < 9.99 else ".0f"
    return f"{100 * fraction:{digits}} %".replace("-", "−")


def bound_percent_text(fraction: float) -> str:
    """A bound on an error as a percentage, rounded up to two digits: 0.01642 → 1.7 %."""
    return f"{units.error_text(100 * fraction)} %"


def signed_text(value: float, digits: int = 2) -> str:
    """A number with its sign; in words where it is not known."""
    sign = "+" if value else ""
    return f"{value:{sign}.{digits}g}".replace("-", "−") if math.isfinite(value) else "not known"


def five_digit_text(value: float) -> str:
    """Five digits; what is zero but for rounding, beside parameters of order 1 to 100, reads 0."""
    return "0" if abs(value) < 1e-12 else f"{value:.5g}".replace("-", "−")


def with_minus_signs(sentence: str) -> str:
    """A sentence of the library, whose numbers have hyphens, as pages have it."""
    return re.sub(r"(?<=\s)-(?=\d)", "−", sentence)


def rounded_up_text(value: float) -> str:
    """The next number with two digits that is not below a positive value: 2.11e-7 → 2.2e-07."""
    return f"{units.round_up_error(value):.1e}" if value > 0 else "0"


def max_simulation_error_fraction(forces: pd.DataFrame) -> float:
    """The largest estimated error of simulations, a fraction of the force."""
    return float((forces["force_error_n"] / forces["force_n"].abs()).max())


def simulation_error_note(*forces: pd.DataFrame) -> str:
    """A line on the largest error estimate of simulations."""
    largest = max(map(max_simulation_error_fraction, forces))
    return f"Simulations: estimated error ≤ {rounded_up_text(largest)} of the force."


def reynolds_validity_limit(films: str) -> ValidityLimit:
    """The limit of validity in the modified Reynolds number of films of a kind."""
    return next(
        limit for limit in VALIDITY_LIMITS if limit.symbol == "Re" and limit.film_kind == films
    )


def inertia_page_values(config: Study) -> dict[str, Any]:
    """Estimate the size of the gas inertia in a study, for pages that have no scene.

    Returns ``reynolds_per_h0_square``, the modified Reynolds number ρωh0²/μ over h0² in 1/m²;
    ``most_reynolds``, above which its modelling error is unverified; ``beyond``, what a larger
    one means.
    """
    gas, omega = config.gas, 2 * math.pi * config.actuator.frequency_hz
    # ``auto`` has inertia and thermal effects where they matter.
    kind = "thermal effects included" if gas.thermal != "none" else "inertia included"
    kind = kind if gas.inertia != "none" else "inertia neglected"
    limit = reynolds_validity_limit(kind)
    beyond = f"{kind}, modelling error unverified above Re {limit.unverified_above:g}"
    if limit.not_applicable_above < math.inf:
        beyond += f"; above Re {limit.not_applicable_above:g} the equation does not apply"
    return {
        "reynolds_per_h0_square": omega * gas.density_kg_per_m3 / gas.viscosity_pa_s,
        "most_reynolds": limit.unverified_above,
        "beyond": f"{beyond}.",
    }


def validity_note(config: Study) -> str:
    """A line for a study whose gaps exceed the equation's validity; empty where none does."""
    per_square, most, beyond = inertia_page_values(config).values()
    h0_m = config.screen.h0_m.stop
    if (reynolds := per_square * h0_m**2) <= most:
        return ""
    edge_um = 1e6 * math.sqrt(most / per_square)
    return (
        f"Beyond Re {most:g} from h0 = {edge_um:.3g} µm: Re = ρωh0²/μ is {reynolds:.3g} at "
        f"{1e6 * h0_m:.3g} µm ({beyond})"
    )

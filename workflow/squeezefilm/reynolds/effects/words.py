"""A budget in words and as a row of a table; derivatives in words."""

from __future__ import annotations

from math import isnan

from squeezefilm.io.solution import DERIVATIVES, Derivatives
from squeezefilm.io.tables import THIS_SCENE
from squeezefilm.reynolds.effects import rim
from squeezefilm.reynolds.effects.budget import Budget, Effect
from squeezefilm.units import to_its_error

# Per cent of the force, from which on an effect that is left out is spoken of.
LEAST_PERCENT = 0.5
# Per cent of the force, from which on the error of depth-averaged terms is shown.
LEAST_SHOWN = 0.01
ABOVE = " (first order, above its range)"
CALLED = {
    "inertia": "inertia",
    "heat": "heat",
    "depth_averaged": "the error of depth-averaged terms",
    "slip": "slip",
    "kinetic": "what first-order slip lacks",
    "rim": "the rim's entrance loss",
    "bearing": "sliding",
    "passing": "the profile that passes a sliding finger",
}


def notes_of_budget(budget: Budget) -> list[str]:
    """What is left out and moves the force by half a per cent or more; or why that is not known."""
    if budget.status != "ok":
        return [f"what the equation leaves out is not known: {budget.status}"]
    basis = f"; of {budget.basis}" if budget.basis else ""
    return [
        f"{CALLED[name]}, left out, {_said(name, effect)}{basis}"
        for name, effect in budget.effects.items()
        if not effect.in_force and _reach(name, effect) >= LEAST_PERCENT
    ]


def budget_text(budget: Budget) -> str:
    """Every effect and their sum on one line."""
    if budget.status != "ok":
        return f"not known: {budget.status}"
    shown = [
        _shown(name, effect)
        for name, effect in budget.effects.items()
        if not (_reach(name, effect) < LEAST_SHOWN if effect.estimate else effect.percent == 0)
    ]
    least, most = budget.sums(left_out_only=True)
    left_out = "not known" if isnan(least) else f"{_band(least, most)} with higher orders"
    if budget.above_range:
        left_out += f" (above the range of first orders: {', '.join(budget.above_range)})"
    basis = f" (of {budget.basis})" if budget.basis else ""
    return f"{', '.join(shown)}; left out in all {left_out}{basis}"


def derivatives_text(derivatives: Derivatives) -> str:
    """A line for each number that changes the force."""
    if derivatives.status != "ok":
        return f"derivatives: {derivatives.status}"
    return "\n".join(
        "dF/d {}: {} ± {} {}".format(
            name, *to_its_error(derivatives.value[number], derivatives.error[number]), unit
        )
        for number, (name, _, unit) in DERIVATIVES.items()
        if derivatives.value[number] or derivatives.error[number]
    )


def budget_row(budget: Budget) -> dict[str, object]:
    """A budget as columns of a table, in per cent of the force.

    ``…_missed_percent`` is the size of what higher orders add, where it is known; the rim is for
    C = 1, and for the largest C in ``rim_most_percent``. The sums' ends are for both, and with all
    that the effects may be off by. ``in_force`` names what the force has already, ``above_range``
    what is too large for a first order.
    """
    row: dict[str, object] = {}
    for name, effect in budget.effects.items():
        row[f"{name}_percent"] = effect.percent
        if name != "bearing":
            row[f"{name}_missed_percent"] = effect.missed_percent
    row["rim_most_percent"] = rim.MOST * budget.rim.percent
    for what, only in (("sum", False), ("left_out", True)):
        ends = budget.sums(left_out_only=only)
        row |= {f"{what}_{end}_percent": value for end, value in zip(ENDS, ends, strict=True)}
    effects = budget.effects.items()
    return row | {
        "in_force": "; ".join(name for name, each in effects if each.in_force),
        "above_range": "; ".join(name for name, each in effects if not each.usable),
        "basis": budget.basis or THIS_SCENE,
        "status": budget.status,
    }


ENDS = ("least", "most")


def _reach(name: str, effect: Effect) -> float:
    """Most that an effect may change, in per cent; NaN where it is not known."""
    size = abs(effect.percent) * (rim.MOST if name == "rim" else 1.0)
    return size + effect.missed_percent * effect.estimate


def _said(name: str, effect: Effect) -> str:
    if effect.estimate:
        return f"is {_estimated(effect)} of the force"
    change = "takes" if effect.percent < 0 else "adds"
    size = abs(effect.percent)
    if name == "rim":
        band = f"{change} {rim.LEAST * size:.2g} to {rim.MOST * size:.2g} % of the force"
        missed = rim.MOST * effect.missed_percent
        higher = f" at first order (higher ones: {missed:.1g} %)" if effect.usable else ABOVE
        return band + higher
    if not effect.usable:
        return f"{change} part of the force: {size:.2g} % at first order, which is above its range"
    missed = effect.missed_percent
    return f"{change} {size:.2g} % of the force at first order (higher ones: {missed:.1g} %)"


def _shown(name: str, effect: Effect) -> str:
    label = CALLED[name].removeprefix("the ")
    if isnan(effect.percent):
        return f"{label} not known"
    if effect.estimate:
        return f"{label} {_estimated(effect)}"
    above = "" if effect.usable else ABOVE
    if name == "rim":
        ends = sorted((rim.LEAST * effect.percent, rim.MOST * effect.percent), key=abs)
        return f"{label} {_band(*ends)}{above}"
    return f"{label} {effect.percent:+.2g} %{', in it' if effect.in_force else ''}{above}"


def _estimated(effect: Effect) -> str:
    return f"about {effect.percent:+.2g} % ± {effect.missed_percent:.1g} %"


def _band(first: float, last: float) -> str:
    return f"{first:+.2g} to {last:+.2g} %"

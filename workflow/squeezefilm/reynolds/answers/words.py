"""Answers beside the mean force in words."""

from __future__ import annotations

from squeezefilm.io.solution import OUTPUTS, Outputs
from squeezefilm.units import to_its_error


def outputs_text(outputs: Outputs) -> list[str]:
    """A line for each number that is known, and one for each output that is refused."""
    shown = [
        "{}: {} ± {} {}".format(name, *to_its_error(outputs.value[name], outputs.error[name]), unit)
        for output in outputs.asked
        for name, (_, unit) in OUTPUTS[output].items()
        if name in outputs.value
    ]
    return shown + [f"{name}: none, {reason}" for name, reason in outputs.refused.items()]

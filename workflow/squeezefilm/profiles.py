"""Vibration shapes s(x, y) of an actuator's surface, with maximum 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np


class Profile(Protocol):
    """A normalised amplitude of vibration over the actuator's surface."""

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Amplitude over its maximum at positions from the actuator's centre, any common shape."""
        ...


@dataclass(frozen=True)
class Sinc:
    """s = sin(πkr)/(πkr), the paper's eq. (2) with k = 109.8 per metre (MATLAB's sinc)."""

    wave_number_per_m: float

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.sinc(self.wave_number_per_m * np.hypot(x_m, y_m))


@dataclass(frozen=True)
class Piston:
    """s = 1: a flat surface that moves as a whole, the case of the paper's eq. (6)."""

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.ones(np.broadcast(x_m, y_m).shape)


KINDS: dict[str, type] = {"sinc": Sinc, "piston": Piston}


def make_profile(*, kind: str, **settings: Any) -> Profile:
    """The profile of a config's ``actuator.profile`` section, whose keys the schema has checked."""
    return KINDS[kind](**settings)

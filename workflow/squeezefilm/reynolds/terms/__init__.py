"""The terms that the film equation may have beside squeezing, one module each.

Here alone are they listed, in the order in which they are spoken of.
"""

from __future__ import annotations

from functools import lru_cache, reduce
from math import inf
from typing import Any

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene, Scenes
from squeezefilm.film.symmetry import axisymmetric_mask
from squeezefilm.reynolds.terms.bearing import Bearing
from squeezefilm.reynolds.terms.edge_pressure import EdgePressure
from squeezefilm.reynolds.terms.gap import NonuniformGap
from squeezefilm.reynolds.terms.inertia import Inertia, VelocityTerm
from squeezefilm.reynolds.terms.outline import RadialFilm, SmoothOutline
from squeezefilm.reynolds.terms.polytropic import Polytropic
from squeezefilm.reynolds.terms.rarefaction import FlowFactor, Rarefaction
from squeezefilm.reynolds.terms.term import (
    KERNEL_HOOK_PARAMETERS,
    AbsentTerm,
    NamedArrays,
    NamedNumbers,
    Term,
)
from squeezefilm.reynolds.terms.thermal import Thermal

__all__ = ["KERNEL_HOOK_PARAMETERS", "TERM_CLASSES", "AbsentTerm", "NamedArrays", "Term", "Terms"]

TERM_CLASSES: tuple[type[Term], ...] = (
    NonuniformGap,
    SmoothOutline,
    Bearing,
    Rarefaction,
    Polytropic,
    Inertia,
    Thermal,
)
Terms = tuple[Term, ...]

# Terms that a program has which is compiled for others, and that a film's row turns on: the budget
# of one force solves films with and without each of them, and a program takes seconds to compile
# and 30 ms to load. The second are in that of films with one of them, and of a few films with none.
ALWAYS_COMPILED_TERMS: Terms = (EdgePressure(),)
COMPILED_TOGETHER_TERMS: Terms = (FlowFactor(), Inertia(), Thermal())
SWITCHABLE_TERM_NAMES = tuple(
    term.NAME for term in (*ALWAYS_COMPILED_TERMS, *COMPILED_TOGETHER_TERMS)
)


def terms_of(scene: Scene) -> Terms:
    """The terms that a scene has."""
    return tuple(term for kind in TERM_CLASSES if (term := kind.of(scene)) is not None)


def terms_label(terms: Terms) -> str:
    """Return the terms of an equation as tables show them."""
    return "; ".join(["squeeze", *(term.label for term in terms)])


@lru_cache(maxsize=64)
def compiled_terms(terms: Terms, *, many: bool) -> Terms:
    """Return the terms of the program that solves films of some terms, and others.

    Args:
        many: whether the films are so many that a program with fewer terms, some per cent faster,
            outweighs its loading. Their states are the same within rounding.
    """
    more = ALWAYS_COMPILED_TERMS
    if not many or any(isinstance(term, (VelocityTerm, Rarefaction)) for term in terms):
        more += COMPILED_TOGETHER_TERMS
    compiled = {term.NAME: term for term in (*more, *terms)}
    if FlowFactor.NAME in compiled:
        compiled.pop(Rarefaction.NAME, None)
    return tuple(sorted(compiled.values(), key=_term_order))


def _term_order(term: Term) -> int:
    return next((place for place, kind in enumerate(TERM_CLASSES) if isinstance(term, kind)), -1)


def absent_terms(terms: Terms) -> tuple[AbsentTerm, ...]:
    """Return the terms that are not among ``terms``, with the reasons."""
    absent = [kind for kind in TERM_CLASSES if not any(isinstance(term, kind) for term in terms)]
    return tuple(kind.ABSENT_TERM for kind in absent if kind.ABSENT_TERM)


def distinct_term_sets(scenes: Scenes) -> tuple[list[Terms], np.ndarray]:
    """Return the distinct combinations of terms, and each scene's index into them, (n,)."""
    known: dict[Terms, int] = {}
    which = np.empty(len(scenes), dtype=np.int64)
    for film, rows, scenes_of_film in scenes.split_by_film():
        pad_positions, at = scenes_of_film.pad_positions
        kind = axisymmetric_mask(pad_positions)[at] + 2 * (
            not film.pad.gap.flat and NonuniformGap.two_preconditioners_mask(scenes_of_film)
        )
        of_film = np.empty(len(scenes_of_film), dtype=np.int64)
        for kind_of_row in {*kind.tolist()}:
            terms = terms_of(scenes_of_film[int(np.argmax(kind == kind_of_row))])
            of_film[kind == kind_of_row] = known.setdefault(terms, len(known))
        which[rows] = of_film
    return list(known), which


def equation_numbers(scene: Scenes, terms: Terms) -> NamedNumbers:
    """The dimensionless numbers of scenes' equation; ``flow``, unless a term says it: H³ρ ∇P.

    ``lag`` is that of the flow behind what drives it, in units of 1/ω, and ``slow`` the share of
    the harmonics that lag (time_modes.py), no more of them than ``waves_per_node`` for each node
    across the pad. ``warming`` is the gas' relative rise of temperature over that of the pressure
    in a fast change, and ``warming_lag`` the lag within which a change is fast.
    """
    numbers: dict[str, Any] = {
        "epsilon": scene.epsilon,
        "sigma": scene.sigma,
        "flow": (1.0,),
        "lag": 0.0,
        "slow": 1.0,
        "waves_per_node": inf,
        "warming": 0.0,
        "warming_lag": 0.0,
    }
    for term in terms:
        numbers.update(term.equation_numbers(scene))
    return numbers


def max_layer_sigma_factor(scene: OperatingPoints, terms: Terms, *, sigma: Any) -> Any:
    """Factor of σ in the choice of the first grid for the edge's boundary layers."""
    return reduce(np.maximum, (term.layer_sigma_factor(scene, sigma=sigma) for term in terms), 1.0)


@lru_cache(maxsize=64)
def flow_axis_count(terms: Terms) -> int:
    """Axes along which gas flows: one in a film without angle, else two."""
    return 1 if is_radial(terms) else 2


def is_radial(terms: Terms) -> bool:
    """Return whether the film has no angle, and is solved along its radius."""
    return any(isinstance(term, RadialFilm) for term in terms)


@lru_cache(maxsize=64)
def have_velocity_terms(terms: Terms) -> bool:
    """Return whether some terms are of the gas' velocities."""
    return any(isinstance(term, VelocityTerm) for term in terms)


@lru_cache(maxsize=64)
def unknown_field_count(terms: Terms) -> int:
    """Return the number of fields that the periodic state solves for."""
    return 1 + flow_axis_count(terms) * sum(term.VELOCITY_FIELD_COUNT for term in terms)


def flow_term_count(terms: Terms) -> int:
    """Terms of the mass flux: viscous flow, and that of a rarefied gas."""
    return 1 + any(isinstance(term, Rarefaction) for term in terms)


def preconditioner_count(terms: Terms) -> int:
    """Preconditioners that share the rows of the linear system; 0 if there is one for all."""
    return max(
        (term.preconditioner_count for term in terms if isinstance(term, NonuniformGap)), default=0
    )


def work_field_count(terms: Terms, *, single: bool = False) -> int:
    """Return the number of work fields that the terms need beside the unknowns."""
    linear = sum(term.LINEAR_FIELD_COUNT for term in terms)
    return sum(term.WORK_FIELD_COUNT for term in terms) + (linear // 2 if single else linear)


def validity_notes(scene: Scene) -> list[str]:
    """Return the notes of the terms on a scene near the end of their range."""
    return [note for kind in TERM_CLASSES if (note := kind.note(scene))]


def unsupported_on_grid_reason(scene: Scene, terms: Terms) -> str:
    """Return the reason why the periodic state is not supported with some terms, or empty."""
    return next(filter(None, (term.unsupported_on_grid_reason(scene) for term in terms)), "")

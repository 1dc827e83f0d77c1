"""A term of the film equation: the only source for methods and explanations.

What an instance does not say is that of a term which changes nothing there, and a method that a
term says nothing about does not know it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene, Scenes

if TYPE_CHECKING:  # for types alone: grids ask the terms
    from squeezefilm.reynolds.grid import Grid

# Where kernels add what terms have to say: to the residual of film_over_period.cl and its response
# to a change of the mass, and, for unknowns of their own, to a step of Newton's method and to the
# way from grid to grid (periodic.cl).
KERNEL_HOOK_PARAMETERS = {
    "residual": "(g, film, mass, work, out)",
    "response": "(g, film, mass, work, out)",
    "step": "(g, film, step, share)",
    "carry": "(g, film, coarser, coarse)",
}

# A number is one for all scenes, or of shape (n,); a tuple of such is a row of them.
NamedNumbers = Mapping[str, Any]
NamedArrays = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class AbsentTerm:
    """A term that the equation of a scene does not have.

    Attributes:
        name: of the term.
        absence_reason: why the equation does not have it.
        assumption: what the equation assumes without a term; empty where that is said elsewhere.
    """

    name: str
    absence_reason: str
    assumption: str = ""


@dataclass(frozen=True)
class Term:
    """A term as a scene has it; scenes of equal terms may share a kernel.

    Attributes:
        label: what tables and ``simulate --dry-run`` call it.
        ABSENT_TERM: name and reason for a scene that does not have it, if they are shown.
        SYMMETRY_BROKEN_AXES: the axes, of "xy", about whose middle the film is not even because of
            it.
        KERNEL_FILE: OpenCL source of its lines for the periodic state.
        KERNEL_HOOKS: those of KERNEL_HOOK_PARAMETERS that this source fills, by functions
            ``HOOK_NAME``.
        SUPPORTS_SINGLE_PRECISION: whether its lines in the linear system work in single precision
            too.
        VELOCITY_FIELD_COUNT: fields along each axis that the periodic state solves for beside the
            pressure.
        WORK_FIELD_COUNT, LINEAR_FIELD_COUNT: room that its lines need beside that, in fields, and
            in fields of the linear system.
        SPACE_MATRIX_PRODUCT_COUNT, TIME_MATRIX_PRODUCT_COUNT: products along each of x and y, and
            in time, that its lines add to a Krylov iteration.
        INTERPOLATION_MATRIX_NAMES: names of the matrices that carry its unknowns from grid to grid.
        OPERATOR_NAMES, EQUATION_NUMBER_WIDTHS: names of what ``scene_operators`` and
            ``equation_numbers`` have that films without it lack in a program which has the term
            (``compiled_terms``); how many numbers, 0 for one.
        SUPPORTS_EXPANSIONS: whether the expansions for σ → ∞ (asymptotics/) are derived with the
            term.
    """

    label: str = field(init=False)

    NAME: ClassVar[str]
    ABSENT_TERM: ClassVar[AbsentTerm | None] = None
    SYMMETRY_BROKEN_AXES: ClassVar[str] = ""
    KERNEL_FILE: ClassVar[str] = ""
    KERNEL_HOOKS: ClassVar[tuple[str, ...]] = ()
    SUPPORTS_SINGLE_PRECISION: ClassVar[bool] = False
    VELOCITY_FIELD_COUNT: ClassVar[int] = 0
    WORK_FIELD_COUNT: ClassVar[int] = 0
    LINEAR_FIELD_COUNT: ClassVar[int] = 0
    SPACE_MATRIX_PRODUCT_COUNT: ClassVar[int] = 0
    TIME_MATRIX_PRODUCT_COUNT: ClassVar[int] = 0
    INTERPOLATION_MATRIX_NAMES: ClassVar[tuple[str, ...]] = ()
    OPERATOR_NAMES: ClassVar[tuple[str, ...]] = ()
    EQUATION_NUMBER_WIDTHS: ClassVar[Mapping[str, int]] = {}
    SUPPORTS_EXPANSIONS: ClassVar[bool] = False

    @classmethod
    def of(cls, scene: Scene) -> Term | None:
        """The term as the scene has it, if it does."""
        raise NotImplementedError

    @classmethod
    def note(cls, scene: Scene) -> str:
        """Return a note where a scene is near the end of the term's range; empty elsewhere."""
        return ""

    def equation_numbers(self, scene: Scenes) -> NamedNumbers:
        """Coefficients of the term for scenes, by their names in the kernels."""
        return {}

    def layer_sigma_factor(self, scene: OperatingPoints, *, sigma: Any) -> Any:
        """Largest factor of σ in the choice of the first grid for the edge's boundary layers."""
        return 1.0

    def matrices(self, grid: Grid, *, aspect: float) -> NamedArrays:
        """Return the term's own matrices of a grid, by their names in the kernels.

        ``aspect`` is the pad's length along y over that along x, the unit of lengths.
        """
        return {}

    def profile_fields(self, parts: np.ndarray, grid: Grid) -> NamedArrays:
        """Return fields of the gaps' parts (packing.py), shape (places, parts, nx, ny) each.

        ``parts`` have the shape (places, parts, full nx + 2, full ny + 2), ends included.
        """
        return {}

    def interpolation_matrices(self, coarse: Grid, fine: Grid) -> NamedArrays:
        """The matrices of CARRYING between two grids."""
        return {}

    def scene_operators(self, numbers: np.ndarray, grid: Grid, *, aspect: float) -> NamedArrays:
        """Return the operators of each scene for the periodic state, each shape (scenes, …).

        A name that the grid has too takes the place of that one's.
        """
        return {}

    def unsupported_on_grid_reason(self, scene: Scene) -> str:
        """Return the reason why the periodic state is not supported with the term, or empty."""
        return ""

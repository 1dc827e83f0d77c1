"""What solving a scene gives, whatever the method: the columns of a table of forces."""

from dataclasses import dataclass, field, fields
from math import nan


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The mean force of one scene and how it was obtained; a scene that was not tried has no more
    than a status and a method.

    Attributes:
        force_n: mean force over a period; NaN unless ``status`` is ``ok``.
        force_error_n: estimate of its absolute error.
        status: ``ok``, or what went wrong.
        method: name of the method.
        left_out: what the scene did not need.
        nx, ny, nt: collocation points across the finger, or along a radius and around for an
            elliptical one, and over the period.
        newton_steps, krylov_iterations: over all grids.
        residual: estimate of the mass error that Newton's iteration left, relative to p0 h0.
        work: floating-point operations of the iterations, for sharing out run time; no column.
    """

    force_n: float = nan
    force_error_n: float = nan
    status: str
    method: str
    left_out: str = ""
    nx: int = 0
    ny: int = 0
    nt: int = 0
    newton_steps: int = 0
    krylov_iterations: int = 0
    residual: float = 0.0
    work: float = field(default=0.0, metadata={"column": False})


SOLUTION_COLUMNS = tuple(
    each.name for each in fields(Solution) if each.metadata.get("column", True)
)

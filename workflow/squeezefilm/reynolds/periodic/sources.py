"""Which sources a kernel over the period is made of."""

from functools import lru_cache

from squeezefilm.reynolds.terms import Terms


def in_single(terms: Terms) -> bool:
    """Whether GMRES works in single precision: residual and state are double, so that only its
    steps are rounded. Most terms' own lines in the linear system are written for doubles.
    """
    return all(term.IN_SINGLE or "response" not in term.HOOKS for term in terms)


@lru_cache(maxsize=64)
def sources_of(terms: Terms, *, single: bool) -> tuple[str, ...]:
    own = [term.OVER_PERIOD for term in terms if term.OVER_PERIOD]
    vectors = ["vectors.cl"] * (2 if single else 1)
    grid = ["linear_algebra.cl", *vectors, "periodic/grid_over_period.cl"]
    return (*grid, *own, "periodic/film_over_period.cl", "krylov.cl", "periodic/periodic.cl")

"""Random studies one after the other, and what of their statements is sure and wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from squeezefilm.api.models import Study
from squeezefilm.errors import InputError
from squeezefilm.tables import write_table
from verification.comparisons import OUTCOMES, Comparison, compared
from verification.coverage import coverage
from verification.random_studies import random_study

CENTRED_MODELS = ("two_factor", "polynomial_3", "quadratic_6", "fast_limit", "limit", "limit_1")
MODELS = (*CENTRED_MODELS, "four_factor", "polynomial_5", "limit_2")
"""Models of the library that a study may offer."""
CHANCE = 1e-3
"""Probability that any coverage of a campaign lies outside its interval by chance."""
POOLED = (0.945, 0.955)
"""Coverage of all 95 % intervals together."""
COVERAGE_KINDS = ("disc", "plate", "scan")

Check = Callable[[Study], Iterator[Comparison]]


def statements(
    seeds: Iterable[int], *, points: int = 2, output: Path | None = None
) -> pd.DataFrame:
    """Forces, errors, gaps, responses and validity of studies, a row for each comparison.

    Args:
        seeds: of the studies.
        points: scenes that are simulated of each.
        output: a table that grows study by study.
    """
    return _campaign(
        ((seed, "any", {}) for seed in seeds),
        lambda study, seed: compared(study, points=points, seed=seed),
        output=output,
    )


def coverages(
    seeds: Iterable[int],
    *,
    models: Sequence[str] = MODELS,
    fresh: int = 2000,
    sample: int = 1000,
    output: Path | None = None,
) -> pd.DataFrame:
    """Points inside the prediction intervals of discs, plates and scans in turn.

    Args:
        seeds: of the studies.
        models: that are fitted to each study, where it offers them.
        fresh: points drawn for each study.
        sample: points of each validation sample.
        output: a table that grows study by study.
    """
    seeds = list(seeds)
    level = CHANCE / (len(seeds) * len(models) * 2)
    settings: dict[str, object] = {"validation": {"points": sample}}
    kinds = (COVERAGE_KINDS[k % len(COVERAGE_KINDS)] for k in range(len(seeds)))
    return _campaign(
        ((seed, kind, settings) for seed, kind in zip(seeds, kinds, strict=True)),
        lambda study, seed: coverage(
            study, models, fresh=fresh, seed=10_000 + seed, level_of_test=level
        ),
        output=output,
    )


def _campaign(
    drawn: Iterable[tuple[int, str, dict[str, object]]],
    check: Callable[[Study, int], Iterator[Comparison]],
    *,
    output: Path | None,
) -> pd.DataFrame:
    tables = []
    with TemporaryDirectory() as name:
        for seed, kind, settings in drawn:
            try:
                study = random_study(seed, folder=Path(name), kind=kind, **settings)
            except InputError:
                continue  # drawn outside what a configuration may be
            rows = [asdict(each) | {"outcome": each.outcome} for each in check(study, seed)]
            tables.append(pd.DataFrame(rows).assign(seed=seed, study=str(study)))
            if output is not None:
                write_table(pd.concat(tables, ignore_index=True), output)
    return pd.concat(tables, ignore_index=True)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Number of comparisons by command, quantity and outcome."""
    counts = pd.crosstab([table["command"], table["quantity"]], table["outcome"])
    return counts.reindex(columns=list(OUTCOMES), fill_value=0).reset_index()


def pooled_coverage(table: pd.DataFrame) -> float:
    """Share of all fresh points that lie inside their 95 % interval."""
    of_95 = table[table["quantity"].str.endswith("within 95 %")]
    fresh = of_95["quantity"].str.extract(r"points of (\d+)", expand=False).astype(float)
    return float(of_95["direct"].sum() / fresh.sum())

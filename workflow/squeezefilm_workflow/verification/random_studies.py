"""Random studies: every statement about them, compared with direct solutions."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from squeezefilm.cli.options import command, flag_option, option
from squeezefilm.errors import InputError, RunError
from squeezefilm.parallel import track_progress
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.verification.comparisons import (
    COMPARISON_OUTCOMES,
    Comparison,
    compare_coverage,
    compare_study,
)
from squeezefilm_workflow.verification.study_generator import random_study

# Models of the library that a study may offer, centred ones first.
MODEL_NAMES = (
    *("two_factor", "polynomial_3", "quadratic_6", "fast_limit", "limit", "limit_1"),
    *("four_factor", "polynomial_5", "limit_2"),
)
# Probability that any coverage of a campaign lies outside its interval by chance.
MISCOVERAGE_PROBABILITY = 1e-3
# Coverage of all 95 % intervals together.
POOLED_COVERAGE_RANGE = (0.945, 0.955)
COVERAGE_STUDY_KINDS = ("disc", "plate", "scan")


@command(
    option("--output", "TABLE.csv", "table to write", required=True),
    option("--studies", "N", "default 12", type=int, default=12),
    option("--seed", help="of the first study; default 1", type=int, default=1),
    option("--points", help="simulated of each study", type=int, default=2),
    flag_option("--coverage", "of prediction intervals"),
    option("--fresh", help="points for each coverage", type=int, default=2000),
)
def random_studies(options: argparse.Namespace) -> None:
    """Random studies: every statement about them, compared with direct solutions.

      squeezefilm-verification random-studies --output TABLE.csv --studies 100 [--seed 1]
      squeezefilm-verification random-studies --output TABLE.csv --coverage [--fresh 2000]

    A study is drawn from a seed: pad, gas, vibration, frequency, ranges of gap and amplitude. The
    first simulates points of each, levitates a load on it and takes its response, and compares
    forces and their errors, modelling errors, gaps, stiffness, gains and validity with direct
    solutions.

    With `--coverage` the library's models are fitted to each study, and fresh points of its
    declared space that lie inside their prediction intervals are counted. The table has a row for
    each comparison and grows study by study; some take minutes of a core. The exit status is 1
    where a statement given as valid does not hold: it is sure and wrong.
    """
    seeds, output = range(options.seed, options.seed + options.studies), Path(options.output)
    if options.coverage:
        table = compare_coverages(seeds, fresh=options.fresh, output=output)
    else:
        table = compare_statements(seeds, points=options.points, output=output)
    print(outcome_counts(table).to_string(index=False))
    failures = [
        f"seed {row['seed']}: {row['command']}: {row['quantity']} ({row['note']})"
        for _, row in table[table["outcome"] == "sure and wrong"].iterrows()
    ]
    if options.coverage:
        of_95 = table[table["quantity"].str.endswith("within 95 %")]
        pooled = of_95["direct"].mean() / options.fresh
        print(f"all 95 % intervals together hold {100 * pooled:.2f} % of the fresh points")
        if not POOLED_COVERAGE_RANGE[0] <= pooled <= POOLED_COVERAGE_RANGE[1]:
            failures.append(f"coverage of all 95 % intervals together: {100 * pooled:.2f} %")
    if failures:
        raise RunError("sure and wrong: " + "; ".join(failures))


def compare_statements(
    seeds: Sequence[int], *, points: int = 2, output: Path | None = None
) -> pd.DataFrame:
    """Forces, errors, gaps, responses and validity of studies, a row for each comparison.

    Args:
        seeds: of the studies.
        points: scenes that are simulated of each.
        output: a table that grows study by study.
    """
    return _comparison_table(seeds, ("any",), partial(compare_study, points=points), output=output)


def compare_coverages(
    seeds: Sequence[int],
    *,
    models: Sequence[str] = MODEL_NAMES,
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
    level = MISCOVERAGE_PROBABILITY / (len(seeds) * len(models) * 2)
    check = partial(compare_coverage, models=models, fresh=fresh, level_of_test=level)
    return _comparison_table(
        seeds, COVERAGE_STUDY_KINDS, check, output=output, validation={"points": sample}
    )


def _comparison_table(
    seeds: Sequence[int],
    kinds: Sequence[str],
    check: Callable[..., Iterator[Comparison]],
    *,
    output: Path | None,
    **settings: object,
) -> pd.DataFrame:
    tables = []
    progress = track_progress(len(seeds), unit="seed", name="random studies")
    with TemporaryDirectory() as name, progress as bar:
        for k, seed in enumerate(seeds):
            bar.done = k
            kind = kinds[k % len(kinds)]
            try:
                study = random_study(seed, folder=Path(name), kind=kind, **settings)
            except InputError:
                continue  # drawn outside what a configuration may be
            rows = [
                asdict(comparison) | {"outcome": comparison.outcome}
                for comparison in check(study, seed=seed)
            ]
            tables.append(pd.DataFrame(rows).assign(seed=seed, study=str(study)))
            if output is not None:
                write_table(pd.concat(tables, ignore_index=True), output)
    return pd.concat(tables, ignore_index=True)


def outcome_counts(table: pd.DataFrame) -> pd.DataFrame:
    """Number of comparisons by command, quantity and outcome."""
    counts = pd.crosstab([table["command"], table["quantity"]], table["outcome"])
    return counts.reindex(columns=list(COMPARISON_OUTCOMES), fill_value=0).reset_index()

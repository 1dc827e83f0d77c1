"""Random studies: every statement about them, compared with direct solutions.

  python -m verification random-studies --output TABLE.csv [--studies 100] [--seed 1]
  python -m verification random-studies --output TABLE.csv --coverage [--studies 12] [--fresh 2000]

A study is drawn from a seed: pad, gas, vibration, frequency, ranges of gap and amplitude. The first
simulates points of each, levitates a load on it and takes its response, and compares forces and
their errors, modelling errors, gaps, stiffness, resonance, gains and validity with direct
solutions. With `--coverage` the library's models are fitted to each study, and fresh points of its
declared space that lie inside their prediction intervals are counted. The table has a row for each
comparison and grows study by study. The exit status is 1 where a statement given as valid does not
hold: it is sure and wrong.
"""

import argparse
from pathlib import Path

from squeezefilm.errors import RunError
from verification.random_campaign import (
    POOLED,
    coverages,
    pooled_coverage,
    statements,
    summary,
)

STUDIES, STUDIES_FOR_COVERAGE = 100, 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument(
        "--studies",
        type=int,
        metavar="N",
        help=f"{STUDIES} if left out, {STUDIES_FOR_COVERAGE} for the coverage",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the first study; 1 if left out")
    parser.add_argument("--points", type=int, default=2, help="simulated of each study")
    parser.add_argument("--coverage", action="store_true", help="of prediction intervals")
    parser.add_argument("--fresh", type=int, default=2000, help="points for each coverage")


def run(options: argparse.Namespace) -> None:
    count = options.studies or (STUDIES_FOR_COVERAGE if options.coverage else STUDIES)
    seeds = range(options.seed, options.seed + count)
    output = Path(options.output)
    if options.coverage:
        table = coverages(seeds, fresh=options.fresh, output=output)
    else:
        table = statements(seeds, points=options.points, output=output)
    print(summary(table).to_string(index=False))
    wrong = table[table["outcome"] == "sure and wrong"]
    failures = [
        f"seed {row['seed']}: {row['command']}: {row['quantity']} ({row['note']})"
        for _, row in wrong.iterrows()
    ]
    if options.coverage:
        pooled = pooled_coverage(table)
        print(f"all 95 % intervals together hold {100 * pooled:.2f} % of the fresh points")
        if not POOLED[0] <= pooled <= POOLED[1]:
            failures.append(f"coverage of all 95 % intervals together: {100 * pooled:.2f} %")
    if failures:
        raise RunError("sure and wrong: " + "; ".join(failures))

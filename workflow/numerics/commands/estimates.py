"""Are forces as good as they say? Random films without inertia, each held against a judge.

python -m numerics estimates --output TABLE.csv [--draw any-gap] [--films N] [--first K] [--seed S]

Excursion ratios 0.01 to 0.98, squeeze numbers 0.1 to 1e6, bearing numbers up to 300, any position,
smooth, measured, ridged, kinked and narrow profiles, tolerances 1e-1 to 1e-7, by the periodic
state and by the method that ``auto`` takes; or gaps of any shape: rectangles that are tilted or
bulge, surfaces that move in two phases, excursions up to 0.9 of the gap at rest, squeeze numbers 1
to 1e5, bearing numbers up to 30, tolerances 1e-1 to 1e-6. The judge solves on grids that share no
node with the force's, to a hundredth of its tolerance. The table grows film by film, dear ones
last, and a run that was stopped goes on.
"""

import argparse
from pathlib import Path

from numerics.estimates.campaign import DRAWS, campaign, refusals, summary
from numerics.estimates.judge import MOST_WORK
from squeezefilm.reynolds.device import choose_device

SEED = 15


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--draw", choices=list(DRAWS), default="even-gap", help="kind of gaps")
    parser.add_argument("--films", type=int, default=500, metavar="N", help="500 if left out")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="number of the first")
    parser.add_argument("--seed", type=int, default=SEED, help=f"{SEED} if left out")
    parser.add_argument(
        "--most-work",
        type=float,
        default=MOST_WORK,
        metavar="FLOPS",
        help=f"of the judge on one grid, {MOST_WORK:g} if left out: less judges fewer films",
    )


def run(options: argparse.Namespace) -> None:
    table = campaign(
        draw=options.draw,
        first=options.first,
        films=options.films,
        seed=options.seed,
        output=Path(options.output),
        device=choose_device(),
        most_work=options.most_work,
    )
    print(summary(table).to_string(index=False))
    print(refusals(table).to_string())

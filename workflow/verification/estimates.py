"""Forces of random films compared with direct solutions: error over error estimate."""

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.cli.options import command, option
from squeezefilm.errors import InputError, RunError
from squeezefilm.files import write_text
from squeezefilm.film.scene import Scene
from squeezefilm.parallel import progress_of
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.grid import iteration_flops
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.resolution import first_grids
from verification.origin import origin
from verification.random_films import RandomFilm, random_film

# Tolerance of a direct solution over that of the film, and the least.
TIGHTER, TIGHTEST = 0.01, 1e-8
# Operations of an iteration on the first grids of the direct solution, beyond which a film is not
# examined: about one of eight of the films drawn, and most of the time of all.
MOST_WORK = 1e8
# Films between two writings of the table.
BATCH = 10
QUANTILES = (0.5, 0.9, 0.99, 0.999)
OUTCOMES = ("within", "outside", "no force", "no direct solution", "not examined")
NUMBERS = [field.name for field in fields(RandomFilm)]


@command(
    option("--output", "TABLE.csv", "table of films to write or go on with", required=True),
    option("--summary", "SUMMARY.csv", "its quantiles by term and tolerance", required=True),
    option("--films", "N", "default 100", type=int, default=100),
    option("--seed", help="default 1", type=int, default=1),
)
def estimates(options: argparse.Namespace) -> None:
    """Compare forces of random films with direct solutions: error over error estimate.

      python -m verification estimates --films 5000 --output FILMS.csv --summary SUMMARY.csv

    Films are drawn by their dimensionless numbers (verification/random_films.py states how) and
    solved by the periodic method at tolerances from 1e-2 to 1e-6 in turn. Direct solutions have a
    hundredth of the tolerance, at least 1e-8. The error is the distance of both, the estimate that
    of both. The table grows film by film, and a run that was stopped goes on. The exit status is
    1 where an error is larger than its estimate.
    """
    output, numbers = Path(options.output), range(1, options.films + 1)
    table = _table_so_far(output, seed=options.seed)
    missing = [number for number in numbers if number not in {*table["film"]}]
    with progress_of(len(missing), unit="film", name="estimates") as bar:
        for start in range(0, len(missing), BATCH):
            some = missing[start : start + BATCH]
            rows = examined({number: random_film(number, seed=options.seed) for number in some})
            new = pd.DataFrame(rows).assign(seed=options.seed)
            table = pd.concat([table, new]) if len(table) else new
            write_text(table.to_csv(index=False), output)
            bar.update(len(some))
    table = table[table["film"].isin(numbers)]
    shown = summary(table)
    call = f"estimates --films {options.films} --seed {options.seed} --output FILMS.csv"
    head = origin(f"{call} --summary {Path(options.summary).name}")
    write_text(head + shown.to_csv(index=False), options.summary)
    print(shown.to_string(index=False))
    outside = table.loc[table["outcome"] == "outside", "film"]
    if len(outside):
        raise RunError(f"{output}: films outside their estimates: {', '.join(map(str, outside))}")


def _table_so_far(path: Path, *, seed: int) -> pd.DataFrame:
    """Raises InputError for a table of another seed, or another table."""
    if not path.exists():
        return pd.DataFrame({"film": []})
    table = pd.read_csv(path)
    if not {"film", "seed"} <= {*table} or set(table["seed"]) != {seed}:
        raise InputError(f"{path}: no table of films of seed {seed}; name another --output")
    return table


def examined(films: dict[int, RandomFilm]) -> list[dict[str, Any]]:
    """Rows of films by their numbers: the film, its force, the direct one and the outcome."""
    rows = []
    tolerances = {film.tolerance for film in films.values()}
    for tolerance in sorted(tolerances):
        alike = {number: film for number, film in films.items() if film.tolerance == tolerance}
        scenes = {number: film.scene for number, film in alike.items()}
        cheap = [n for n in alike if _work(scenes[n], direct_tolerance(tolerance)) <= MOST_WORK]
        found = dict(zip(cheap, _forces([scenes[n] for n in cheap], tolerance), strict=True))
        direct = direct_forces([scenes[n] for n in cheap], tolerance=tolerance)
        compared = dict(zip(cheap, direct, strict=True))
        for number, film in alike.items():
            row = {"film": number, **asdict(film)}
            rows.append(row | _outcome(found.get(number), compared.get(number)))
    return rows


def direct_tolerance(tolerance: float) -> float:
    """Return the tolerance of a direct solution."""
    return max(TIGHTER * tolerance, TIGHTEST)


def direct_forces(scenes: Sequence[Scene], *, tolerance: float) -> np.ndarray:
    """Mean overpressures over p0 and their errors far within a tolerance, (n, 2)."""
    return _forces(scenes, direct_tolerance(tolerance))


def _forces(scenes: Sequence[Scene], tolerance: float) -> np.ndarray:
    solved = solve(scenes, tolerance=tolerance, method="periodic") if scenes else []
    pairs = zip(scenes, solved, strict=True)
    return np.array(
        [np.array([one.force_n, one.force_error_n]) / scene.force_scale_n for scene, one in pairs]
    )


def _work(scene: Scene, tolerance: float) -> float:
    """Operations of an iteration on the first grids; infinite where there are none."""
    groups = first_grids(needs_of(scene), tolerance=tolerance)
    return max((iteration_flops(group.grids[-1], group.terms) for group in groups), default=inf)


def _outcome(found: np.ndarray | None, direct: np.ndarray | None) -> dict[str, Any]:
    if found is None or direct is None:
        return {"outcome": "not examined"}
    (force, estimate), (exact, exact_error) = found, direct
    row = {"force": force, "estimate": estimate, "direct": exact, "direct_error": exact_error}
    if np.isnan(force):
        return row | {"outcome": "no force"}
    if np.isnan(exact):
        return row | {"outcome": "no direct solution"}
    ratio = abs(force - exact) / (estimate + exact_error)
    outcome = "within" if ratio <= 1 else "outside"
    return row | {"error_over_estimate": ratio, "outcome": outcome}


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Quantiles of error over estimate, the largest, and counts: by term, tolerance, and of all."""
    parts: Iterable[tuple[str, pd.DataFrame]] = [
        *((f"terms: {name}", part) for name, part in table.groupby("group", sort=False)),
        *((f"tolerance: {value:g}", part) for value, part in table.groupby("tolerance")),
        ("all", table),
    ]
    rows = []
    for name, part in parts:
        ratios, counts = part["error_over_estimate"], part["outcome"].value_counts()
        quantiles = {f"{100 * q:g} %": f"{ratios.quantile(q):.2g}" for q in QUANTILES}
        worst = {"largest error over estimate": f"{ratios.max():.2g}"}
        rows.append(
            {
                "films": name,
                **{each: counts.get(each, 0) for each in OUTCOMES},
                **quantiles,
                **worst,
            }
        )
    return pd.DataFrame(rows)


@command(option("--output", "TABLE.csv", "table to solve again", required=True, type=Path))
def stored_films(options: argparse.Namespace) -> None:
    """Solve the stored films that need a guard of the error estimate again.

    python -m verification stored-films --output tests/numerics/data/judged_films.csv
    """
    table = read_films(options.output)
    for index, row in table.iterrows():
        film = film_of(row)
        ((force, error),) = direct_forces([film.scene], tolerance=film.tolerance)
        table.loc[index, ["force", "force_error"]] = float(f"{force:.9g}"), float(f"{error:.2g}")
    head = origin(f"stored-films --output {options.output}")
    write_text(head + table.to_csv(index=False), options.output)


def read_films(path: Path) -> pd.DataFrame:
    """Return a table of stored films: name, guards, numbers, force and its error over p0 A."""
    return pd.read_csv(path, comment="#", dtype={"quadrature": str})


def film_of(row: pd.Series) -> RandomFilm:
    """Return the film of a table's row."""
    return RandomFilm(**{name: row[name] for name in NUMBERS})

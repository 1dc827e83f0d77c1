"""Forces of random films compared with direct solutions: error over error estimate."""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd

from squeezefilm.cli.options import command, flag_option, option
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.parallel import track_progress
from squeezefilm.reynolds import error_estimate, solve
from squeezefilm.reynolds.periodic import refinement, resolution
from squeezefilm.reynolds.periodic.launch import RESULT_DTYPE
from squeezefilm.reynolds.periodic.resolution import min_convergence_ratio
from squeezefilm.reynolds.terms import distinct_term_sets
from squeezefilm_workflow.verification.origin import write_with_origin
from squeezefilm_workflow.verification.random_films import (
    TOLERANCE_PERCENTAGES,
    RandomFilm,
    random_film,
)

# Least tolerance of a direct solution.
MIN_DIRECT_TOLERANCE = 1e-8
# Films between two writings of the tables.
FILMS_PER_WRITE = 20
QUANTILES = (0.5, 0.9, 0.99, 0.999)
ABOUT_ESTIMATES = (
    "quantiles of the error of a force over its estimate; the error is the difference from a "
    "direct solution at a small part of the tolerance; counts of forces within, outside, without "
    "force, without that solution; even gap: uniform; shaped gap: non-uniform, or two quadrature "
    "components"
)
ABOUT_GUARDS = "the same quantiles on recorded grids, without each guard of the estimate in turn"
ABOUT_STORED = "films outside their estimate without the guards that the name has"
ESTIMATE_OUTCOMES = ("within", "outside", "no force", "no direct solution")
RANDOM_FILM_COLUMNS = [field.name for field in fields(RandomFilm)]
# Guards of the error estimate, and the value with which each changes nothing.
ERROR_ESTIMATE_GUARDS: dict[str, tuple[Any, float]] = {
    "CHANGE_SIZE_FRACTION": (error_estimate, 0.0),
    "RATIO_SAFETY_FACTOR": (error_estimate, 1.0),
    "DEFAULT_CONVERGENCE_RATIO": (error_estimate, 0.0),
    "THIN_LAYER_CONVERGENCE_RATIO": (resolution, 0.0),
    "THIN_LAYER_VELOCITY_CONVERGENCE_RATIO": (resolution, 0.0),
    "ERRATIC_CONVERGENCE_SIGMA": (resolution, float("inf")),
    "ERRATIC_VELOCITY_SIGMA": (resolution, float("inf")),
    "VELOCITY_CHANGE_SIZE_FRACTION": (error_estimate, 0.0),
    "RESOLVED_MODES_FRACTION": (error_estimate, 0.0),
    "UNRESOLVED_CHANGE_FRACTION": (error_estimate, 0.0),
}


@dataclass(frozen=True)
class Campaign:
    """Random films, and how they are solved.

    Attributes:
        direct_tolerance_ratio: tolerance of a direct solution over that of the film.
        max_unknowns: of the finest grids; with more, few films take most of the time.
    """

    with_inertia: bool = False
    direct_tolerance_ratio: float = 0.01
    max_unknowns: int = 20_000

    def film(self, number: int, *, seed: int) -> RandomFilm:
        """Return the film of a number."""
        if not self.with_inertia:
            return random_film(number, seed=seed)
        film = random_film(
            number,
            seed=seed,
            groups={"inertia": 60, "thermal": 40},
            profiles={"piston": 30, "smooth": 70},
            sigma=(1.0, 1e4),
            reynolds=(0.05, 20.0),
        )
        return replace(film, tolerance=min(TOLERANCE_PERCENTAGES))

    def direct_tolerance(self, tolerance: float) -> float:
        """Return the tolerance of a direct solution."""
        direct = max(self.direct_tolerance_ratio * tolerance, MIN_DIRECT_TOLERANCE)
        return float(f"{direct:.0e}")


ALL_TERMS_CAMPAIGN = Campaign()
INERTIA_CAMPAIGN = Campaign(with_inertia=True, direct_tolerance_ratio=0.1, max_unknowns=30_000)


@command(
    option("--output", "TABLE.csv", "table of forces to write or go on with", required=True),
    option("--summary", "SUMMARY.csv", "its quantiles by term and tolerance", required=True),
    option("--grids", "GRIDS.csv", "table of the forces on all grids to write or go on with"),
    option("--films", "N", "default 100", type=int, default=100),
    option("--seed", help="default 1", type=int, default=1),
    flag_option("--with-inertia", "films with inertia or thermal effects alone"),
)
def estimates(options: argparse.Namespace) -> None:
    """Compare forces of random films with direct solutions: error over error estimate.

      squeezefilm-verification estimates --films 5000 --output FORCES.csv --summary SUMMARY.csv

    Films are drawn by their dimensionless numbers (verification/random_films.py states how) and
    solved by the periodic method at the drawn tolerance, from 1e-2 to 1e-6, and at all looser ones,
    on grids of at most 20 000 unknowns. The direct solution has a hundredth of the tolerance or
    less. The error is the distance of both, the estimate that of both.

    With --with-inertia films have a smooth mode shape, σ to 10⁴ and Re to 20, tolerances to 1e-6,
    30 000 unknowns, and direct solutions of a tenth of the tolerance.

    The tables grow film by film, and a run that was stopped goes on. The exit status is 1 where an
    error is larger than its estimate.
    """
    output, numbers = Path(options.output), range(options.films)
    campaign = INERTIA_CAMPAIGN if options.with_inertia else ALL_TERMS_CAMPAIGN
    origin = {"seed": options.seed, "with_inertia": options.with_inertia}
    table = _read_unfinished_table(output, **origin)
    missing = [number for number in numbers if number not in {*table["film"]}]
    with track_progress(len(missing), unit="film", name="estimates") as bar:
        for start in range(0, len(missing), FILMS_PER_WRITE):
            film_numbers = missing[start : start + FILMS_PER_WRITE]
            rows, grids = force_and_grid_rows(
                {n: campaign.film(n, seed=options.seed) for n in film_numbers}, campaign
            )
            if options.grids:
                _append_to_table(pd.DataFrame(grids), Path(options.grids))
            _append_to_table(pd.DataFrame(rows).assign(**origin), output)
            bar.update(len(film_numbers))
    table = _read_unfinished_table(output, **origin)
    table = with_outcomes(table[table["film"].isin(numbers)], campaign)
    shown = outcome_summary(table)
    call = f"estimates --films {options.films} --seed {options.seed} --output FORCES.csv"
    call += " --with-inertia" * options.with_inertia
    call += f" --summary {Path(options.summary).name}"
    write_with_origin(shown, options.summary, command=call, about=ABOUT_ESTIMATES)
    print(shown.to_string(index=False))
    outside = table.loc[table["outcome"] == "outside", "film"].unique()
    if len(outside):
        raise RunError(f"{output}: films outside their estimates: {', '.join(map(str, outside))}")


def _append_to_table(table: pd.DataFrame, path: Path) -> None:
    with path.open("a") as file:
        table.to_csv(file, index=False, header=file.tell() == 0)


def _read_unfinished_table(path: Path, **origin: Any) -> pd.DataFrame:
    """Raises InputError for a table of other films, or another table."""
    if not path.exists():
        return pd.DataFrame({"film": []})
    table = pd.read_csv(path)
    if not {"film", *origin} <= {*table} or (table[[*origin]] != [*origin.values()]).any(axis=None):
        films = " of ".join(["films", *(f"{name} {value}" for name, value in origin.items())])
        raise InputError(f"{path}: no table of {films}; name another --output")
    return table


def force_and_grid_rows(
    films: dict[int, RandomFilm], campaign: Campaign = ALL_TERMS_CAMPAIGN
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return rows of films' forces, a row a tolerance, and rows of the grids behind them."""
    scenes = {number: replace(film.scene, point_id=str(number)) for number, film in films.items()}
    ended: set[int] = set()
    rows = []
    with (
        record_grids() as grids,
        patch.object(refinement, "MAX_UNKNOWNS", campaign.max_unknowns),
    ):
        directs = map(campaign.direct_tolerance, TOLERANCE_PERCENTAGES)
        for tolerance in sorted({*TOLERANCE_PERCENTAGES, *directs}, reverse=True):
            film_numbers = [
                n
                for n, film in films.items()
                if n not in ended
                and (
                    (tolerance in TOLERANCE_PERCENTAGES and tolerance >= film.tolerance)
                    or tolerance == campaign.direct_tolerance(film.tolerance)
                )
            ]
            forces = _gauge_pressures_and_errors([scenes[n] for n in film_numbers], tolerance)
            for number, (force, error) in zip(film_numbers, forces, strict=True):
                film = films[number]
                head = {"film": number, "group": film.group}
                head |= {"epsilon": film.epsilon, "sigma": film.sigma, "tolerance": tolerance}
                rows.append(head | {"force": force, "estimate": error})
                if np.isnan(force):  # nor is there one at a tighter tolerance
                    ended.add(number)
    return rows, grids


def _gauge_pressures_and_errors(scenes: Sequence[Scene], tolerance: float) -> np.ndarray:
    """Mean gauge pressures over p0 and their errors, (n, 2)."""
    solved = solve(scenes, tolerance=tolerance, method="periodic")
    scale_n = np.array([scene.force_scale_n for scene in scenes])
    return np.stack([solved.force_n, solved.force_error_n], axis=-1) / scale_n[:, None]


@contextmanager
def record_grids() -> Iterator[list[dict[str, Any]]]:
    """Record what error estimates are made from, a row for each scene and pair of grids."""
    rows: list[dict[str, Any]] = []
    estimate = refinement.estimate_errors

    def record_and_estimate(results: np.ndarray, before: np.ndarray, **given: Any) -> Any:
        for k, film in enumerate(given["scenes"].point_id):
            row = {"film": int(film), "tolerance": given["tolerance"]}
            row["first"] = bool(np.isnan(before[1, k]))
            row |= {name: results[name][k].item() for name in RESULT_DTYPE.names or ()}
            rows.append(row | {"of_profile": given["of_profile"][k]})
        return estimate(results, before, **given)

    with patch.object(refinement, "estimate_errors", record_and_estimate):
        yield rows


def with_outcomes(table: pd.DataFrame, campaign: Campaign = ALL_TERMS_CAMPAIGN) -> pd.DataFrame:
    """Return a table of forces with ``direct``, ``error_over_estimate`` and ``outcome``.

    Direct is a film's force at the least tolerance, where that is tight enough for the row's; rows
    of forces that are direct alone are left away.
    """
    solved = table.dropna(subset="force").sort_values("tolerance").drop_duplicates("film")
    columns = {"tolerance": "direct_tolerance", "force": "direct", "estimate": "direct_error"}
    direct = solved.rename(columns=columns)[["film", *columns.values()]]
    table = table[table["tolerance"].isin(TOLERANCE_PERCENTAGES)].merge(
        direct, on="film", how="left"
    )
    known = table["direct_tolerance"] <= table["tolerance"].map(campaign.direct_tolerance) * (
        1 + 1e-9
    )
    off = (table["force"] - table["direct"]).abs()
    ratio = (off / (table["estimate"] + table["direct_error"])).where(known)
    outcome = np.select(
        [table["force"].isna(), ~known, ratio <= 1],
        ["no force", "no direct solution", "within"],
        "outside",
    )
    return table.assign(error_over_estimate=ratio, outcome=outcome)


def outcome_summary(table: pd.DataFrame) -> pd.DataFrame:
    """Quantiles of error over estimate, the largest, and counts: by term, tolerance, and of all."""
    parts: Iterable[tuple[str, pd.DataFrame]] = [
        *((f"terms: {name}", part) for name, part in table.groupby("group", sort=False)),
        *((f"tolerance: {value:g}", part) for value, part in table.groupby("tolerance")),
        ("all", table),
    ]
    rows = []
    for name, part in parts:
        ratios, counts = part["error_over_estimate"], part["outcome"].value_counts()
        rows.append(
            {
                "forces": name,
                "films": part["film"].nunique(),
                **{outcome: counts.get(outcome, 0) for outcome in ESTIMATE_OUTCOMES},
                **{f"{100 * q:g} %": f"{ratios.quantile(q):.2g}" for q in QUANTILES},
                "largest error over estimate": f"{ratios.max():.2g}",
            }
        )
    return pd.DataFrame(rows)


def guard_switched_off(guard: str) -> AbstractContextManager[Any]:
    """A context in which one of ERROR_ESTIMATE_GUARDS is switched off."""
    owner, off = ERROR_ESTIMATE_GUARDS[guard]
    return patch.object(owner, guard, off)


@dataclass(frozen=True)
class RecordedGrids:
    """Recorded grids of films with direct solutions, in the order of each film's way.

    Attributes:
        table: a row for each film, tolerance and pair of grids.
        earlier_grid_pair_counts: number of pairs of grids before that one whose changes are known,
            (n,).
        results: of ``estimate``, (n,).
        scenes: that of each row.
    """

    grid_table: pd.DataFrame
    earlier_grid_pair_counts: np.ndarray
    results: np.ndarray
    scenes: Scenes

    @classmethod
    def of_tables(cls, forces: pd.DataFrame, grids: pd.DataFrame) -> "RecordedGrids":
        """Join tables of ``estimates``; films without a direct solution have no row.

        Raises InputError where no film has one.
        """
        with_inertia = bool(forces.get("with_inertia", pd.Series([False])).iloc[0])
        campaign = INERTIA_CAMPAIGN if with_inertia else ALL_TERMS_CAMPAIGN
        known = with_outcomes(forces, campaign).dropna(subset="error_over_estimate")
        if known.empty:
            raise InputError("no film of the table has a direct solution; examine more films")
        columns = ["film", "tolerance", "direct", "direct_error"]
        table = grids.drop_duplicates().merge(known[columns], on=["film", "tolerance"])
        table = table.sort_values(["film", "tolerance"], kind="stable", ignore_index=True)
        grids_before = np.arange(len(table))
        grids_before -= np.maximum.accumulate(np.where(table["first"], grids_before, 0))
        results = np.zeros(len(table), dtype=RESULT_DTYPE)
        for name in RESULT_DTYPE.names or ():
            results[name] = table[name]
        seed = known["seed"].iloc[0]
        drawn = {number: campaign.film(number, seed=seed).scene for number in {*table["film"]}}
        scenes = Scenes.of([drawn[number] for number in table["film"]])
        return cls(table, grids_before, results, scenes)

    def accepted_error_ratios(self) -> pd.Series:
        """Return error over estimate on the first grid of each film whose estimate is enough."""
        error, allowed = self._estimated_and_allowed_errors()
        enough = (error <= allowed) & (self.results["status"] == 0) & (self.results["lowest"] > 0)
        off = np.abs(self.results["mean"] - self.grid_table["direct"])
        ratio = (off / (error + self.grid_table["direct_error"])).set_axis(
            pd.MultiIndex.from_frame(self.grid_table[["film", "tolerance"]])
        )
        ratio = ratio[enough]
        return ratio[~ratio.index.duplicated()]

    def _estimated_and_allowed_errors(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the errors that are estimated of all rows, and those that are allowed."""
        error, allowed = np.empty((2, len(self.grid_table)))
        change = np.full((2, len(self.grid_table) + 1), np.nan)
        kinds, kind = distinct_term_sets(self.scenes)
        keys = np.column_stack([self.earlier_grid_pair_counts, kind, self.grid_table["tolerance"]])
        different, which = np.unique(keys, axis=0, return_inverse=True)
        for group, (grids_before, of_kind, tolerance) in enumerate(different):
            at = np.flatnonzero(which == group)
            scenes = self.scenes[at]
            error[at], allowed[at], change[:, at] = refinement.estimate_errors(
                self.results[at],
                change[:, at - 1] if grids_before else np.full((2, len(at)), np.nan),
                scenes=scenes,
                terms=kinds[int(of_kind)],
                of_profile=self.grid_table["of_profile"].to_numpy()[at],
                least=min_convergence_ratio(scenes, kinds[int(of_kind)]),
                tolerance=float(tolerance),
            )
        return error, allowed


@command(
    option("--forces", "FORCES.csv", "table of `estimates`", required=True, type=Path),
    option("--grids", "GRIDS.csv", "table of its grids", required=True, type=Path),
    option("--output", "TABLE.csv", "table to write", required=True),
)
def guards(options: argparse.Namespace) -> None:
    """Estimate the errors of recorded forces again, without each guard of the error estimate.

      squeezefilm-verification guards --forces FORCES.csv --grids GRIDS.csv --output TABLE.csv

    Nothing is solved: a film is accepted on the first of its recorded grids whose estimate meets
    the tolerance, which may be an earlier one without a guard. The films outside their estimates
    then are those that need it.
    """
    forces, grids = pd.read_csv(options.forces), pd.read_csv(options.grids)
    recorded = RecordedGrids.of_tables(forces, grids)
    rows = []
    for guard in ("none", *ERROR_ESTIMATE_GUARDS):
        with guard_switched_off(guard) if guard in ERROR_ESTIMATE_GUARDS else nullcontext():
            ratios = recorded.accepted_error_ratios()
        outside = ratios[ratios > 1]
        numbers = outside.index.get_level_values("film").unique()
        rows.append(
            {
                "guard switched off": guard,
                "forces": len(ratios),
                **{f"{100 * q:g} %": f"{ratios.quantile(q):.2g}" for q in QUANTILES},
                "largest error over estimate": f"{ratios.max():.3g}",
                "outside": len(outside),
                "films outside": " ".join(map(str, numbers[:5])),
            }
        )
    table = pd.DataFrame(rows)
    call = f"guards --forces FORCES.csv --grids GRIDS.csv --output {options.output}"
    write_with_origin(table, options.output, command=call, about=ABOUT_GUARDS)
    print(table.to_string(index=False))


@command(option("--output", "TABLE.csv", "table to go on with", required=True, type=Path))
def stored_films(options: argparse.Namespace) -> None:
    """Solve the stored films that need a guard of the error estimate, where their force is empty.

      squeezefilm-verification stored-films --output tests/numerics/data/judged_films.csv

    Each force is written as soon as it is known.
    """
    table = read_stored_films(options.output)
    for index, row in table[table["force"].isna()].iterrows():
        film = film_of_row(row)
        tolerance = ALL_TERMS_CAMPAIGN.direct_tolerance(film.tolerance)
        ((force, error),) = _gauge_pressures_and_errors([film.scene], tolerance)
        table.loc[index, ["force", "force_error"]] = float(f"{force:.9g}"), float(f"{error:.2g}")
        call = f"stored-films --output {options.output}"
        write_with_origin(table, options.output, command=call, about=ABOUT_STORED)


def read_stored_films(path: Path) -> pd.DataFrame:
    """Return a table of stored films: name, guards, numbers, force and its error over p0 A."""
    return pd.read_csv(path, comment="#", dtype={"quadrature": str})


def film_of_row(row: pd.Series) -> RandomFilm:
    """Return the film of a table's row."""
    return RandomFilm(**{name: row[name] for name in RANDOM_FILM_COLUMNS})

"""Error against run time of every method, each along its own path of refinement.

A path is a list of settings made by a rule that is written down, here or in the other method's own
module, not by looking at errors: the parts of a method's error shall fall at the same rate from
rung to rung. A rung that takes
longer than a given time is the last of its path.
"""

import importlib
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np
import pandas as pd

from numerics.any_gap.cases import BULGING, TILTED, travelling
from numerics.films import Film, balanced_points
from numerics.peers.fixed_grid import solve_on_grid
from numerics.peers.yardstick import Fold
from numerics.reference import Reference, reference_force
from numerics.timing import cold_start, measure
from squeezefilm.io.errors import RunError
from squeezefilm.io.found import modules_in
from squeezefilm.io.progress import say
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid

FILMS = (
    *(
        Film(f"ε = {epsilon:g}, σ = {sigma:g}", epsilon, sigma)
        for epsilon in (0.1, 0.44)
        for sigma in (20.0, 583.0, 2331.0)
    ),
    Film("off centre, ε = 0.4, σ = 2331", 0.4, 2331.0, x=0.29),
    Film("ε = 0.9, σ = 583", 0.9, 583.0),
    Film("inertia, Re = 0.45, ε = 0.44, σ = 2331", 0.44, 2331.0, reynolds=0.45),
    Film("inertia, Re = 1.8, off centre, ε = 0.2, σ = 583", 0.2, 583.0, x=0.29, reynolds=1.8),
    Film("travelling wave, ε = 0.44, σ = 583", 0.44, 583.0, profile=travelling()),
    Film("tilted by 0.4, ε = 0.4, σ = 583", 0.4, 583.0, gap=TILTED),
    Film("bulging by 0.3, ε = 0.4, σ = 583", 0.4, 583.0, gap=BULGING),
    Film("ellipse, ε = 0.4, σ = 583", 0.4, 583.0, shape="ellipse", aspect=0.7),
)
COLD_FILM = FILMS[4]
COLD_PEERS = {"periodic_numpy": 5, "chebyshev_anderson": 3, "elements_anderson": 2}
"""Methods that are started cold, each with its rung."""
NUMPY = "NumPy, SciPy"
# Methods by their keys; what a reader sees is the figure's matter.
PERIODIC = "periodic"
# Other methods of the solver, each with its own region of validity.
LADDER = ("fast-limit", "boundary-layer", "small-amplitude", "matched-limit")
CHOSEN = "auto"
# The periodic state of a film with inertia, its inertia left out.
WITHOUT = "without_inertia"
OWN = (CHOSEN, PERIODIC, WITHOUT, *LADDER)
# Of the force that others are held against with inertia or of an ellipse, which no other method
# knows; and the least tolerance that is held against it.
REFERENCE_TOLERANCE, LEAST_WITH_INERTIA = 1e-8, 1e-7
REFERENCE_OF_ELLIPSE, LEAST_OF_ELLIPSE = 1e-6, 1e-5


@dataclass(frozen=True)
class Answer:
    """A mean force in p0 l0^2, the error that the method claims for it (NaN: none), its status."""

    force: float
    estimated_error: float = np.nan
    status: str = "ok"


Run = Callable[[], Answer]


@dataclass(frozen=True)
class Rung:
    """One setting of a method on its path: what it is, and the call that solves `batch` films.

    device: where it runs, if not on the solver's.
    """

    method: str
    path: str
    settings: str
    run: Run
    batch: int = 1
    device: str = ""


def work_precision(
    films: tuple[Film, ...],
    *,
    repeats: int,
    batch: int,
    longest_seconds: float,
    rungs: int,
    model_error: float,
    device: Device,
) -> pd.DataFrame:
    """Rows: each film by each method, forces in units of p0 l0^2, seconds per film.

    repeats, longest_seconds: timings per rung, and the CPU seconds beyond which a path ends;
    batch: films solved together; rungs: the most of any path; model_error: relative error of the
    empirical model, noted in every row.
    """
    rows = []
    for film in films:
        say(film.name)
        known = {}
        if film.reynolds or film.shape != "rectangle":
            reference = _own_reference(film, device=device)
            if film.reynolds:
                known[WITHOUT] = _reference_of(replace(film, reynolds=0.0))
        else:
            reference = _reference_of(film)
        for path in _paths(film, batch=batch, rungs=rungs, device=device):
            for rung in path:
                held_against = known.get(rung.method, reference)
                row = _row(film, rung, held_against, repeats=repeats, device=device)
                rows.append(row)
                if row["cpu_seconds"] * rung.batch > longest_seconds:
                    break
    return pd.DataFrame(rows).assign(model_error=model_error)


def _reference_of(film: Film) -> Reference:
    scene = film.scene
    return reference_force(epsilon=scene.closure(), sigma=film.sigma, gap=scene.gap, fold=film.fold)


def _own_reference(film: Film, *, device: Device) -> Reference:
    """The solver's own force, tighter than asked for: nothing else here knows that film."""
    tolerance = REFERENCE_TOLERANCE if film.reynolds else REFERENCE_OF_ELLIPSE
    (solution,) = solve([film.scene], tolerance=tolerance, method=PERIODIC, device=device)
    if solution.status != "ok":
        raise RunError(f"{film.name}: no reference: {solution.status}")
    found = _answer(film, solution)
    return Reference(force=found.force, uncertainty=found.estimated_error)


def _row(
    film: Film, rung: Rung, reference: Reference, *, repeats: int, device: Device
) -> dict[str, Any]:
    def attempt() -> Answer:
        try:
            return rung.run()
        except RunError as error:
            return Answer(force=np.nan, status=str(error))

    timed = measure(attempt, repeats=repeats)
    answer = timed.result
    return {
        "scene": film.name,
        "epsilon": film.epsilon,
        "sigma": film.sigma,
        "reynolds": film.reynolds,
        "method": rung.method,
        "path": rung.path,
        "batch": rung.batch,
        "start": "warm",
        "settings": rung.settings,
        "status": answer.status,
        "force": answer.force,
        "reference": reference.force,
        "reference_uncertainty": reference.uncertainty / reference.force,
        "relative_error": abs(answer.force / reference.force - 1),
        "estimated_error": answer.estimated_error / reference.force,
        "cpu_seconds": timed.cpu_seconds / rung.batch,
        "wall_seconds": timed.wall_seconds / rung.batch,
        "repeats": timed.repeats,
        "device": rung.device or device.name,
    }


def _paths(film: Film, *, batch: int, rungs: int, device: Device) -> Iterator[Iterator[Rung]]:
    if film.reynolds:
        for method in (PERIODIC, WITHOUT):
            for count in (1, batch):
                yield _by_tolerance(film, method=method, batch=count, device=device, rungs=rungs)
        return
    for method in (CHOSEN, PERIODIC):
        for count in (1, batch):
            yield _by_tolerance(film, method=method, batch=count, device=device, rungs=rungs)
    if film.shape != "rectangle":
        return
    for path in ("balanced", "space", "time"):
        yield _fixed(film, path=path, batch=1, device=device, rungs=rungs)
    yield _fixed(film, path="balanced", batch=batch, device=device, rungs=rungs)
    for method in LADDER:
        yield _limit(film, method, device=device)
    if not film.scene.plain:  # others' methods know H = 1 + ε s sin T alone
        return
    for method, module in peers().items():
        if getattr(module, "installed", lambda: True)():
            yield _peer(film, method, module, rungs)


# The solver of this project


def _decades(rungs: int) -> list[float]:
    """Tolerances of at most so many rungs, from 1e-1 to 1e-10 where all are wanted."""
    return [10.0**-k for k in range(1, 11)][:: max(1, 10 // rungs)]


def _neighbours(film: Film, count: int) -> list[Film]:
    """The film, and others like it within 1 % of its epsilon: a batch with nothing in common."""
    return [replace(film, epsilon=film.epsilon * (1 - 0.01 * k / count)) for k in range(count)]


def _by_tolerance(
    film: Film, *, method: str, batch: int, rungs: int, device: Device
) -> Iterator[Rung]:
    """What a user does: a tolerance is asked for, and the error estimated."""
    least = LEAST_WITH_INERTIA if film.reynolds else 0.0
    least = LEAST_OF_ELLIPSE if film.shape != "rectangle" else least
    like = replace(film, reynolds=0.0) if method == WITHOUT else film
    scenes = [each.scene for each in _neighbours(like, batch)]
    way = PERIODIC if method == WITHOUT else method
    for tolerance in _decades(rungs):
        if tolerance < 0.9 * least:
            break

        def run(tolerance: float = tolerance) -> Answer:
            solutions = solve(scenes, tolerance=tolerance, method=way, device=device)
            return _answer(film, solutions[0])

        yield Rung(method, "tolerance", f"tolerance={tolerance:.0e}", run, batch)


def _answer(film: Film, solution: Solution) -> Answer:
    scale = film.scene.force_scale_n
    return Answer(solution.force_n / scale, solution.force_error_n / scale, solution.status)


def _fixed(film: Film, *, path: str, batch: int, rungs: int, device: Device) -> Iterator[Rung]:
    """Given grids: balanced, or refined in space or in time alone."""
    films = _neighbours(film, batch)
    grids = [_balanced_grid(film, tolerance, fold=film.fold) for tolerance in _decades(rungs)]
    finest = _balanced_grid(film, 1e-10, fold=film.fold)
    if path == "space":
        grids = [replace(grid, nt=finest.nt) for grid in grids]
    elif path == "time":
        grids = [replace(finest, nt=grid.nt) for grid in grids]
    for grid, tolerance in dict(zip(grids, _decades(rungs), strict=True)).items():

        def run(grid: Grid = grid, tolerance: float = tolerance) -> Answer:
            share = 0.03 * (tolerance if path == "balanced" else 1e-10)
            states = solve_on_grid(films, grid=grid, tolerance=share, device=device)
            stalled = states.status[0] != 0
            return Answer(states.mean[0], status="stalled" if stalled else "ok")

        yield Rung(PERIODIC, path, _grid_text(grid), run, batch)


def _balanced_grid(film: Film, tolerance: float, *, fold: Fold) -> Grid:
    nx, ny, nt = balanced_points(film, tolerance, fold=fold)
    return Grid(nx=nx, ny=ny, nt=nt, fold_x=fold[0], fold_y=fold[1])


def _grid_text(grid: Grid) -> str:
    return f"points={grid.x.full_points}x{grid.y.full_points}x{grid.nt}"


def _limit(film: Film, method: str, *, device: Device) -> Iterator[Rung]:
    """A limit that has no settings; outside its region it gives no force."""

    def run() -> Answer:
        solutions = solve([film.scene], tolerance=1e-6, method=method, device=device)
        return _answer(film, solutions[0])

    if np.isfinite(run().force):
        yield Rung(method, "no setting", "", run)


# Other people's methods


def peers() -> dict[str, ModuleType]:
    """The module of every method of numerics.peers that is compared, by the method's key."""
    modules = [importlib.import_module(name) for name in modules_in("numerics.peers").values()]
    return {key: module for module in modules for key in getattr(module, "METHODS", ())}


def _peer(film: Film, method: str, module: ModuleType, rungs: int) -> Iterator[Rung]:
    for level in range(rungs):
        settings = module.METHODS[method](film, level)

        def run(settings: Mapping[str, Any] = settings) -> Answer:
            found = module.periodic_force(
                epsilon=film.epsilon, sigma=film.sigma, amplitude=film.amplitude, **settings
            )
            return Answer(found.force)

        device = getattr(module, "DEVICE", NUMPY)
        yield Rung(method, "balanced", _settings_text(settings), run, device=device)


def _settings_text(settings: Mapping[str, Any]) -> str:
    return " ".join(f"{name}={value:g}" for name, value in settings.items() if name != "fold")


# Cold starts


def cold_starts(*, device: Device, compiling: bool) -> pd.DataFrame:
    """Times of one film in a new process each: kernels in the caches, the peers, and, if
    compiling, with empty caches."""
    film = COLD_FILM
    scene = f"Film({film.name!r}, {film.epsilon}, {film.sigma})"
    own = (
        "from numerics.films import Film; from squeezefilm.reynolds import solve; "
        f"solve([{scene}.scene], tolerance=1e-6, method='periodic')"
    )
    rows = [("tolerance=1e-06", PERIODIC, "cold, kernels compiled before", cold_start(own))]
    if compiling:
        with tempfile.TemporaryDirectory() as folder:
            empty = {"POCL_CACHE_DIR": folder, "XDG_CACHE_HOME": folder}
            times = cold_start(own, environment=empty)
            rows.append(("tolerance=1e-06", PERIODIC, "cold, empty caches", times))
    for method, level in COLD_PEERS.items():
        module = peers()[method]
        settings = module.METHODS[method](film, level)
        call = (
            f"from numerics.films import Film; import {module.__name__} as peer; "
            f"film = {scene}; peer.periodic_force(epsilon=film.epsilon, sigma=film.sigma, "
            f"amplitude=film.amplitude, **{dict(settings)!r})"
        )
        rows.append((_settings_text(settings), method, "cold", cold_start(call)))
    return pd.DataFrame(
        {
            "scene": film.name,
            "epsilon": film.epsilon,
            "sigma": film.sigma,
            "method": method,
            "batch": 1,
            "start": start,
            "settings": settings,
            "status": "ok",
            "cpu_seconds": cpu,
            "wall_seconds": wall,
            "repeats": 1,
            "device": device.name if method == PERIODIC else NUMPY,
        }
        for settings, method, start, (cpu, wall) in rows
    )

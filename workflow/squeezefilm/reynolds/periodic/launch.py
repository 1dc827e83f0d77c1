"""The periodic state on the device: scenes of like terms on grids of their own (periodic.cl)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.device import ALIGNMENT_BYTES, SPARE, Device, aligned, kernel
from squeezefilm.reynolds.grid import CARRYING, Grid, carrying_matrices, grid_matrices
from squeezefilm.reynolds.layout import (
    Columns,
    Pile,
    c_enum,
    c_struct,
    c_terms,
    rows_of,
    scene_by_scene,
)
from squeezefilm.reynolds.periodic.sizes import most_krylov, sizes_of
from squeezefilm.reynolds.periodic.sources import in_single, sources_of
from squeezefilm.reynolds.periodic.time_modes import Steps, steps_of, time_modes
from squeezefilm.reynolds.problems import Problems, mean_motion, problems_of, profile_fields
from squeezefilm.reynolds.terms import Terms, own_fields, unknown_fields

# What stands for no offset.
NOTHING = -1
# How an iteration ends: the kernel's names, and what is said of it.
ENDINGS = {
    "CONVERGED": "ok",
    "STALLED": "Newton's method did not converge",
    "NOT_FINITE": "the pressure became infinite",
}
STATUS = tuple(ENDINGS.values())
MOST_NEWTON = 40


@dataclass(frozen=True)
class Batch:
    """Scenes on one grid after the other: the state on each is the first guess on the next.

    Attributes:
        grids: each no coarser than the one before.
        problems: the scenes as they are on each of the grids.
        guess: first guess of the state on the first grid, shape (scenes, fields, nx, ny, nt); the
            film at rest if left out.
        every: whether the states on all grids are asked for, and not that on the last alone.
    """

    grids: Sequence[Grid]
    problems: Sequence[Problems]
    guess: np.ndarray | None = None
    every: bool = True

    @cached_property
    def scenes(self) -> int:
        return len(self.problems[0])

    @property
    def terms(self) -> Terms:
        return self.problems[0].terms

    @cached_property
    def fields(self) -> int:
        """Fields of a state."""
        return unknown_fields(self.terms)

    @cached_property
    def largest_state(self) -> int:
        """Numbers of a scene's largest state."""
        return self.fields * max(grid.count for grid in self.grids)

    def returns(self, stage: int) -> bool:
        """Whether the states on a grid come back, or a first guess lies where they do."""
        guess = stage == 0 and self.guess is not None
        return self.every or guess or stage == len(self.grids) - 1

    @cached_property
    def workspace_size(self) -> int:
        """Numbers that a work-group needs beside the states: fields, Krylov basis, Hessenberg."""
        flow_terms = self.problems[0].numbers["flow"].shape[1]
        sizes = []
        for grid in self.grids:
            most = most_krylov(grid, self.terms)
            fields = 2 * flow_terms + 3 + own_fields(self.terms)
            linear = 3 * flow_terms + 3 + (most + 1) * self.fields
            matrices = 3 * (grid.nx**2 + grid.ny**2) + 3 * grid.nt**2
            sizes.append(grid.count * (fields + linear) + matrices + (most + 4) * (most + 1))
        return max(sizes) + 2 * self.largest_state


@dataclass(frozen=True)
class States:
    """What the device returns, one entry per scene.

    Attributes:
        kept: the unknowns, or none where the batch does not ask for them.
        mean_in_time: overpressure averaged over the period, shape (scenes, nx, ny).
        mean: mean of p over film and period, the force in units of p0 × area.
        residual: preconditioned residual, an estimate of the mass error left by the iteration.
        largest: largest |p|.
        lowest: smallest pressure P, on the last grid of a launch; NaN on others.
        thinnest: smallest product ρ H, by which the local Knudsen number grows, likewise.
        status: index into STATUS.
        newton_steps, krylov_iterations: work done.
    """

    kept: np.ndarray | None
    mean_in_time: np.ndarray
    mean: np.ndarray
    residual: np.ndarray
    largest: np.ndarray
    lowest: np.ndarray
    thinnest: np.ndarray
    status: np.ndarray
    newton_steps: np.ndarray
    krylov_iterations: np.ndarray

    @property
    def unknowns(self) -> np.ndarray:
        """p = P − 1 on the grid and the terms' own unknowns, shape (scenes, fields, nx, ny, nt)."""
        if self.kept is None:
            raise ValueError("the batch did not ask for the states on this grid")
        return self.kept

    @property
    def overpressure(self) -> np.ndarray:
        """p, shape (scenes, nx, ny, nt)."""
        return self.unknowns[:, 0]


# What the device says of a scene on a grid beside its overpressure: a row of its results.
COUNTS = {"status", "newton_steps", "krylov_iterations"}
SAID = np.dtype(
    [(each.name, np.int64 if each.name in COUNTS else np.float64) for each in fields(States)[2:]]
)


@dataclass(frozen=True)
class _Place:
    """Where a launch's results have what is said of a batch on a grid: slices of them.

    Attributes:
        means: means in time of all scenes, one behind the other.
        states: the states likewise; none where they do not come back.
    """

    means: slice
    states: slice | None


def _places(batches: Sequence[Batch]) -> tuple[list[list[_Place]], int]:
    """The places of each batch on each grid, and the size of the results.

    They begin with what is said in rows; kernels read states in vectors.
    """
    rows = sum(batch.scenes * len(batch.grids) for batch in batches)
    end = -(-rows * SAID.itemsize // ALIGNMENT_BYTES) * ALIGNMENT_BYTES // 8
    places: list[list[_Place]] = []
    for batch in batches:
        places.append([])
        for stage, grid in enumerate(batch.grids):
            means = slice(end, end + batch.scenes * grid.nx * grid.ny)
            end = means.stop
            states = None
            if batch.returns(stage):
                states = slice(end, end + batch.scenes * batch.fields * grid.count)
                end = states.stop
            places[-1].append(_Place(means, states))
    return places, end


def solve_batch(
    *, problems: Problems, grid: Grid, device: Device, guess: np.ndarray | None = None
) -> States:
    """The periodic states of scenes on one grid."""
    return launch([Batch([grid], [problems], guess)], device=device).states()[0][0]


@dataclass(frozen=True)
class Launch:
    """Batches that the device is solving, and the array that it leaves its results in.

    done: the kernel's event.
    """

    batches: Sequence[Batch]
    device: Device
    results: np.ndarray
    buffer: Any
    done: Any

    def states(self) -> list[list[States]]:
        """Wait for the device; the states of each batch on each of its grids."""
        self.device.fetch(self.results, self.buffer, after=self.done)
        places, _ = _places(self.batches)
        rows = sum(batch.scenes * len(batch.grids) for batch in self.batches)
        said = self.results[: rows * SAID.itemsize // 8].view(SAID)
        states: list[list[States]] = []
        first = 0
        for batch, of_batch in zip(self.batches, places, strict=True):
            stages = len(batch.grids)
            last = first + batch.scenes * stages
            states.append([])
            for stage, (grid, place) in enumerate(zip(batch.grids, of_batch, strict=True)):
                shape = batch.scenes, batch.fields, *grid.shape
                unknowns = self.results[place.states].reshape(shape) if place.states else None
                means = self.results[place.means].reshape(batch.scenes, grid.nx, grid.ny)
                own = said[first + stage : last : stages]
                rest = (own[name] for name in SAID.names or ())
                states[-1].append(States(unknowns, means, *rest))
            first = last
        return states


def launch(batches: Sequence[Batch], *, device: Device) -> Launch:
    """Let the device solve batches of like terms; each scene is solved on its own.

    All of a scene's grids come in one launch, for the way to the device and back costs as much as
    a small solve.

    The device takes scenes in the given order: put the dearest first.

    Raises:
        InputError: where compiling the kernel would take so long that it looks like a fault.
    """
    import pyopencl as cl

    terms = batches[0].problems[0].terms
    if device.loops_over_items and own_fields(terms):
        raise InputError(
            f"PoCL may compile {' and '.join(term.label for term in terms)} for work-groups of "
            f"{device.work_items} items for many minutes: take one item, as a processor is given "
            "where none are asked for"
        )
    inputs = _inputs(batches)
    single = in_single(terms)
    periodic_state = kernel(
        device,
        "periodic_state",
        sources=sources_of(terms, single=single),
        header=_header(terms, inputs.rows.dtype, single=single),
    )
    scenes = sum(batch.scenes for batch in batches)
    workspace_size = -(-max(batch.workspace_size for batch in batches) // 8) * 8
    groups = device.groups_for(scenes, workspace_bytes=8 * workspace_size)
    buffer = device.shared(inputs.results)
    done = periodic_state(
        device.queue,
        (groups * device.work_items,),
        (device.work_items,),
        scenes,
        MOST_NEWTON,
        *(device.sent(values) for values in (inputs.begins, inputs.rows, inputs.values)),
        buffer,
        device.sent(np.zeros(1, dtype=np.int32)),
        device.room(workspace_size * groups),
        workspace_size,
        cl.LocalMemory(8 * device.work_items),
    )
    device.queue.flush()
    return Launch(batches, device, results=inputs.results, buffer=buffer, done=done)


@dataclass(frozen=True)
class _Inputs:
    """A launch's arrays, as periodic.cl describes them.

    results: room for what the device says of the scenes, and their first guesses.
    """

    begins: np.ndarray
    rows: np.ndarray
    values: np.ndarray
    results: np.ndarray


def _inputs(batches: Sequence[Batch]) -> _Inputs:
    """The batches' arrays behind each other, and where each scene's parts lie in them."""
    stages = np.concatenate([np.full(batch.scenes, len(batch.grids)) for batch in batches])
    begins = np.concatenate([[0], np.cumsum(stages)])
    places, size = _places(batches)
    results = aligned(size + SPARE)
    pile = Pile()
    rows = []
    for batch, of_batch_at in zip(batches, places, strict=True):
        of_batch = []
        coarser = None
        films = _film_steps(batch.problems[-1], batch.grids[-1])
        scenes = np.arange(batch.scenes)
        for grid, problems, place in zip(batch.grids, batch.problems, of_batch_at, strict=True):
            guess = batch.guess if coarser is None else None
            if place.states and guess is not None:
                results[place.states] = guess.ravel()
            begin = place.states.start if place.states else NOTHING
            step = batch.fields * grid.count if place.states else 0
            where = (
                place.means.start + grid.nx * grid.ny * scenes,
                begin + step * scenes,
                np.full(batch.scenes, guess is not None),
                np.full(batch.scenes, batch.largest_state),
            )
            names = ("means", "state", "guessed", "largest_state")
            of_batch.append(
                rows_of(
                    sizes_of(grid, batch.terms),
                    Columns(names, np.stack(where, axis=1)),
                    *_offsets(pile, problems, films, grid, coarser=coarser),
                    numbers=problems.numbers,
                    # A mass error w moves the pressure by w/H.
                    tolerance=problems.tolerance * problems.narrowest,
                )
            )
            coarser = grid
        rows.append(of_batch)
    return _Inputs(begins.astype(np.int32), scene_by_scene(rows), pile.values, results)


def _offsets(
    pile: Pile, problems: Problems, films: Sequence[Steps], grid: Grid, *, coarser: Grid | None
) -> list[Columns]:
    """Where what a batch needs on one grid lies in the pile, which it is put on."""
    terms, aspect = problems.terms, problems.aspect
    offsets = [
        pile.add(carrying_matrices(coarser, grid, terms=terms))
        if coarser
        else _nothing_to_carry(terms),
        pile.add(grid_matrices(grid, aspect=aspect, terms=terms)),
        pile.add_each(profile_fields(problems, grid), problems.places),
        _time_modes(pile, films, grid),
    ]
    for term in terms:
        if operators := term.operators(problems.numbers, grid, aspect=aspect):
            offsets.append(pile.add_each(operators))
    return offsets


@lru_cache(maxsize=64)
def _nothing_to_carry(terms: Terms) -> Columns:
    names = (*CARRYING, *(name for term in terms for name in term.CARRYING))
    return Columns(names, np.full(len(names), NOTHING))


def _time_modes(pile: Pile, films: Sequence[Steps], grid: Grid) -> Columns:
    """Where each film's modes in time lie in the pile, which they are put on once for all."""
    found = {steps: time_modes(grid.nt, steps).parts for steps in dict.fromkeys(films)}
    begins = {steps: pile.put(parts.values) for steps, parts in found.items()}
    begin = np.array([begins[steps] for steps in films])
    starts = found[films[0]].columns
    return Columns(starts.names, begin[:, None] + starts.values)


def _film_steps(problems: Problems, grid: Grid) -> list[Steps]:
    """What tells the films' modes in time, which are alike on all grids."""
    numbers = problems.numbers
    variation, lagging = mean_motion(problems, grid).T
    return steps_of(variation=variation, lagging=lagging, lag=numbers["lag"], slow=numbers["slow"])


@lru_cache(maxsize=64)
def _header(terms: Terms, row: np.dtype[Any], *, single: bool) -> str:
    """What the sources take as known; terms that no scene of a launch has are not compiled."""
    (flow_terms,) = row["flow"].shape
    return "\n".join(
        [
            f"#define FLOW_TERMS {flow_terms}",
            f"#define UNKNOWN_FIELDS {unknown_fields(terms)}",
            f"#define OWN_FIELDS {own_fields(terms)}",
            "#define SINGLE" if single else "",
            *(f"#define HAS_{term.NAME}" for term in terms),
            c_struct("Row", row),
            c_struct("Said", SAID),
            c_enum(ENDINGS),
            c_terms(terms),
        ]
    )


def warm(device: Device, scene: Scene) -> None:
    """Build and load the kernels that a scene needs, so that the first batch need not wait."""
    grid = Grid(nx=4, ny=4, nt=8, fold_x=False, fold_y=False)
    problems = problems_of([replace(scene, hv_m=0.0)], grid, tolerance=1.0)
    solve_batch(problems=problems, grid=grid, device=device)

"""The periodic state on the device: scenes of like terms on grids of their own (periodic.cl)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.device import ALIGNMENT_BYTES, PADDING, Device, kernel
from squeezefilm.reynolds.grid import CARRYING, Grid, carrying_matrices, grid_matrices
from squeezefilm.reynolds.layout import (
    NOTHING,
    Columns,
    Joined,
    Pile,
    by_stages,
    c_enum,
    c_struct,
    c_terms,
    joined_rows,
    joined_stages,
    nothing,
    rows_of,
)
from squeezefilm.reynolds.periodic.profiles import put_films
from squeezefilm.reynolds.periodic.sizes import most_krylov, sizes_of
from squeezefilm.reynolds.periodic.sources import in_single, sources_of
from squeezefilm.reynolds.periodic.states import ENDINGS, SAID, States
from squeezefilm.reynolds.problems import Problems, problems_of
from squeezefilm.reynolds.terms import Terms, own_fields, parts_of, unknown_fields

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
            linear = 3 * flow_terms + 10 + (most + 1) * self.fields
            matrices = 3 * (grid.nx**2 + grid.ny**2 + grid.nt**2)
            small = (most + 4) * (most + 1) + grid.nx * grid.ny
            sizes.append(grid.count * (fields + linear) + matrices + small)
        return max(sizes) + 2 * self.largest_state


class _Place(NamedTuple):
    """Where a launch's results have what is said of a batch on a grid: slices of them.

    Attributes:
        means: means in time of all scenes, one behind the other.
        states: the states likewise; none where they do not come back.
    """

    means: slice
    states: slice | None


@dataclass(frozen=True)
class _Places:
    """The places of each batch on each grid, and the size of the results.

    They begin with what is said in rows; kernels read states in vectors.
    """

    of: Sequence[Sequence[_Place]]
    rows: int
    size: int


def _places(batches: Sequence[Batch]) -> _Places:
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
    return _Places(places, rows, end)


def solve_batch(
    *, problems: Problems, grid: Grid, device: Device, guess: np.ndarray | None = None
) -> States:
    """The periodic states of scenes on one grid."""
    return launch([Batch([grid], [problems], guess)], device=device).states()[0][0]


@dataclass(frozen=True)
class Launch:
    """Batches that the device is solving; ``done`` is the kernel's event."""

    batches: Sequence[Batch]
    places: _Places
    device: Device
    inputs: _Inputs
    buffer: Any
    done: Any

    def end(self) -> None:
        """Let other launches have the arrays, as no one looks at the states any more."""
        self.device.arrays.release(*self.inputs.arrays)

    def states(self) -> list[list[States]]:
        """Wait for the device; the states of each batch on each of its grids."""
        results = self.inputs.results
        self.device.fetch(results, self.buffer, after=self.done)
        numbers = SAID.itemsize // 8
        said = results[: self.places.rows * numbers].reshape(-1, numbers)
        states: list[list[States]] = []
        first = 0
        for batch, of_batch in zip(self.batches, self.places.of, strict=True):
            stages = len(batch.grids)
            last = first + batch.scenes * stages
            states.append([])
            for stage, (grid, place) in enumerate(zip(batch.grids, of_batch, strict=True)):
                shape = batch.scenes, batch.fields, *grid.shape
                unknowns = results[place.states].reshape(shape) if place.states else None
                means = results[place.means].reshape(batch.scenes, grid.nx, grid.ny)
                own = said[first + stage : last : stages].view(SAID)[:, 0]
                states[-1].append(States(unknowns, means, own))
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
    places = _places(batches)
    inputs = _inputs(batches, places, device)
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
    buffer, values = device.shared(inputs.results), device.shared(inputs.values)
    done = periodic_state(
        device.queue,
        (groups * device.work_items,),
        (device.work_items,),
        scenes,
        MOST_NEWTON,
        *(device.sent(each) for each in (inputs.begins, inputs.rows)),
        values,
        buffer,
        device.sent(np.zeros(1, dtype=np.int32)),
        device.room(workspace_size * groups),
        workspace_size,
        cl.LocalMemory(8 * device.work_items),
    )
    device.queue.flush()
    return Launch(batches, places, device, inputs, buffer, done)


@dataclass(frozen=True)
class _Inputs:
    """A launch's arrays, as periodic.cl describes them.

    results: room for what the device says of the scenes, and their first guesses.
    arrays: what the last two are the beginnings of, of the device's pool.
    """

    begins: np.ndarray
    rows: np.ndarray
    values: np.ndarray
    results: np.ndarray
    arrays: Sequence[np.ndarray]


def _inputs(batches: Sequence[Batch], places: _Places, device: Device) -> _Inputs:
    """The batches' arrays behind each other, and where each scene's parts lie in them."""
    stages = [len(batch.grids) for batch in batches for _ in range(batch.scenes)]
    begins = np.array([*accumulate(stages, initial=0)], dtype=np.int32)
    results_array = device.arrays.acquire(places.size + PADDING)
    results = results_array[: places.size + PADDING]
    pile = Pile()
    rows = []
    for batch, of_batch in zip(batches, places.of, strict=True):
        if batch.guess is not None:
            results[of_batch[0].states] = batch.guess.ravel()
        tolerances = [problems.tolerance for problems in batch.problems]
        rows.append(
            rows_of(
                _columns(pile, batch, of_batch),
                stages=len(batch.grids),
                numbers=batch.problems[0].numbers,
                # A mass error w moves the pressure by w/H.
                tolerance=np.multiply.outer(batch.problems[0].narrowest, tolerances),
            )
        )
    values_array = device.arrays.acquire(pile.end + PADDING)
    values = pile.put_into(values_array[: pile.end + PADDING])
    return _Inputs(begins, joined_rows(rows), values, results, (results_array, values_array))


def _columns(pile: Pile, batch: Batch, places: Sequence[_Place]) -> list[Columns]:
    """A batch's sizes, and where what it needs lies in the pile and the results, on each grid."""
    aspect = batch.problems[0].aspect
    sizes, matrices = _of_grids(tuple(batch.grids), batch.terms, aspect)
    columns = [
        sizes,
        pile.add(matrices),
        _in_results(batch, places),
        *put_films(pile, batch.problems, batch.grids),
    ]
    for term in batch.terms:
        each_grid = zip(batch.problems, batch.grids, strict=True)
        operators = [term.operators(its.numbers, grid, aspect=aspect) for its, grid in each_grid]
        if operators[0]:
            columns.append(by_stages([pile.add_each(of_grid) for of_grid in operators]))
    return columns


@lru_cache(maxsize=64)
def _of_grids(grids: tuple[Grid, ...], terms: Terms, aspect: float) -> tuple[Columns, Joined]:
    """The sizes of some grids, and their matrices with those that carry a state to the next."""
    sizes = [sizes_of(grid, terms) for grid in grids]
    carrying = [
        nothing([*CARRYING, *(name for term in terms for name in term.CARRYING)]),
        *(carrying_matrices(*pair, terms=terms) for pair in pairwise(grids)),
    ]
    matrices = [grid_matrices(grid, aspect=aspect, terms=terms) for grid in grids]
    return (
        Columns(sizes[0].names, np.stack([each.values for each in sizes])),
        joined_stages(list(zip(carrying, matrices, strict=True))),
    )


def _in_results(batch: Batch, places: Sequence[_Place]) -> Columns:
    """Where each scene has its own, on each grid, and what a kernel is to know beside that."""
    begins, steps = [], []
    for stage, (means, states) in enumerate(places):
        guessed = stage == 0 and batch.guess is not None
        begins.append([means.start, states.start if states else NOTHING, guessed])
        steps.append([_step(means, batch), _step(states, batch) if states else 0, 0])
    names = ("means", "state", "guessed", "largest_state")
    values = np.empty((batch.scenes, len(places), len(names)), dtype=np.int64)
    values[..., :-1] = begins + np.multiply.outer(np.arange(batch.scenes), steps)
    values[..., -1] = batch.largest_state
    return Columns(names, values)


def _step(some: slice, batch: Batch) -> int:
    return int((some.stop - some.start) // batch.scenes)


@lru_cache(maxsize=64)
def _header(terms: Terms, row: np.dtype[Any], *, single: bool) -> str:
    """What the sources take as known; terms that no scene of a launch has are not compiled."""
    (flow_terms,) = row["flow"].shape
    return "\n".join(
        [
            f"#define FLOW_TERMS {flow_terms}",
            f"#define UNKNOWN_FIELDS {unknown_fields(terms)}",
            f"#define ROW_PARTS {parts_of(terms)}",
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

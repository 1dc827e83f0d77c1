"""The periodic state on the device: scenes of like terms on grids of their own (periodic.cl)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.device import ALIGNMENT_BYTES, PADDING, Device, kernel
from squeezefilm.reynolds.grid import CARRYING, Grid, carrying_matrices, grid_matrices
from squeezefilm.reynolds.layout import (
    ABSENT,
    Buffer,
    Columns,
    Packed,
    c_enum,
    c_struct,
    c_terms,
    joined_rows,
    packed,
    rows_of,
)
from squeezefilm.reynolds.periodic.sizes import most_krylov, sizes_of
from squeezefilm.reynolds.periodic.states import ENDINGS, SAID, States
from squeezefilm.reynolds.periodic.time_modes import modes_of
from squeezefilm.reynolds.problems import (
    aspect_of,
    mean_motion,
    numbers_table,
    profiles_at,
    terms_of_all,
)
from squeezefilm.reynolds.terms import Arrays, Terms, own_fields, parts_of, unknown_fields

MOST_NEWTON = 40


@dataclass(frozen=True)
class Batch:
    """Scenes on one grid after the other: the state on each is the first guess on the next.

    Attributes:
        scenes: of one finger shape.
        terms: those that all of them have.
        grids: each no coarser than the one before.
        tolerances: relative error of the force that the iteration may leave, on each grid.
        guess: first guess of the state on the first grid, shape (scenes, fields, nx, ny, nt); the
            film at rest if left out.
        every: whether the states on all grids are asked for, and not that on the last alone.
    """

    scenes: Scenes
    terms: Terms
    grids: Sequence[Grid]
    tolerances: Sequence[float]
    guess: np.ndarray | None = None
    every: bool = True

    def __len__(self) -> int:
        return len(self.scenes)

    @cached_property
    def numbers(self) -> np.ndarray:
        """Of the scenes' equation, a row for each."""
        return numbers_table(self.scenes, self.terms)

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
        flow_terms = self.numbers["flow"].shape[1]
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
    rows = sum(len(batch) * len(batch.grids) for batch in batches)
    end = -(-rows * SAID.itemsize // ALIGNMENT_BYTES) * ALIGNMENT_BYTES // 8
    places: list[list[_Place]] = []
    for batch in batches:
        places.append([])
        for stage, grid in enumerate(batch.grids):
            means = slice(end, end + len(batch) * grid.nx * grid.ny)
            end = means.stop
            states = None
            if batch.returns(stage):
                states = slice(end, end + len(batch) * batch.fields * grid.count)
                end = states.stop
            places[-1].append(_Place(means, states))
    return _Places(places, rows, end)


def solve_batch(
    scenes: Scenes | Sequence[Scene], grid: Grid, *, tolerance: float, device: Device
) -> States:
    """The periodic states of scenes of one finger shape and like terms on one grid.

    Raises:
        ValueError: for scenes of unlike terms.
    """
    scenes = Scenes.of(scenes)
    batch = Batch(scenes, terms_of_all(scenes), [grid], [tolerance])
    return launch([batch], device=device).states()[0][0]


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
            last = first + len(batch) * stages
            states.append([])
            for stage, (grid, place) in enumerate(zip(batch.grids, of_batch, strict=True)):
                shape = len(batch), batch.fields, *grid.shape
                unknowns = results[place.states].reshape(shape) if place.states else None
                means = results[place.means].reshape(len(batch), grid.nx, grid.ny)
                own = said[first + stage : last : stages].view(SAID)[:, 0]
                states[-1].append(States(unknowns, means, own))
            first = last
        return states


def in_single(terms: Terms) -> bool:
    """Whether GMRES works in single precision: residual and state are double, so that only its
    steps are rounded. Most terms' own lines in the linear system are written for doubles.
    """
    return all(term.IN_SINGLE or "response" not in term.HOOKS for term in terms)


@lru_cache(maxsize=64)
def sources_of(terms: Terms, *, single: bool) -> tuple[str, ...]:
    """Files that a kernel for some terms is made of, in order."""
    own = [term.OVER_PERIOD for term in terms if term.OVER_PERIOD]
    vectors = ["vectors.cl"] * (2 if single else 1)
    grid = ["linear_algebra.cl", *vectors, "periodic/grid_over_period.cl"]
    return (*grid, *own, "periodic/film_over_period.cl", "krylov.cl", "periodic/periodic.cl")


def launch(batches: Sequence[Batch], *, device: Device) -> Launch:
    """Let the device solve batches of like terms; each scene is solved on its own.

    All of a scene's grids come in one launch, for the way to the device and back costs as much as
    a small solve.

    The device takes scenes in the given order: put the dearest first.

    Raises:
        InputError: where compiling the kernel would take so long that it looks like a fault.
    """
    import pyopencl as cl

    terms = batches[0].terms
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
    scenes = sum(map(len, batches))
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
    stages = [len(batch.grids) for batch in batches for _ in range(len(batch))]
    begins = np.array([*accumulate(stages, initial=0)], dtype=np.int32)
    results_array = device.arrays.acquire(places.size + PADDING)
    results = results_array[: places.size + PADDING]
    buffer = Buffer()
    rows = []
    for batch, of_batch in zip(batches, places.of, strict=True):
        if batch.guess is not None:
            results[of_batch[0].states] = batch.guess.ravel()
        rows.append(
            rows_of(
                _columns(buffer, batch, of_batch),
                stages=len(batch.grids),
                numbers=batch.numbers,
                # A mass error w moves the pressure by w/H.
                tolerance=np.multiply.outer(batch.scenes.narrowest, batch.tolerances),
            )
        )
    values_array = device.arrays.acquire(buffer.size + PADDING)
    values = buffer.put_into(values_array[: buffer.size + PADDING])
    return _Inputs(begins, joined_rows(rows), values, results, (results_array, values_array))


def _columns(buffer: Buffer, batch: Batch, places: Sequence[_Place]) -> list[Columns]:
    """A batch's sizes, and where its arrays lie in the buffer and the results, on each grid."""
    grids, terms, numbers = tuple(batch.grids), batch.terms, batch.numbers
    aspect = aspect_of(batch.scenes)
    sizes, matrices = _of_grids(grids, terms, aspect)
    fields, at, means = profiles_at(batch.scenes, grids, terms)
    motion = mean_motion(numbers, means)
    modes, kinds = modes_of(grids, aspect=aspect, numbers=numbers, motion=motion)
    columns = [
        sizes,
        buffer.add(matrices),
        _in_results(batch, places),
        buffer.add(fields, at),
        buffer.add(modes, kinds),
    ]
    for term in terms:
        operators = [term.operators(numbers, grid, aspect=aspect) for grid in grids]
        if operators[0]:
            columns.append(buffer.add(packed(operators), np.arange(len(batch))))
    return columns


@lru_cache(maxsize=64)
def _of_grids(grids: tuple[Grid, ...], terms: Terms, aspect: float) -> tuple[Columns, Packed]:
    """The sizes of some grids, and their matrices with those that carry a state to the next."""
    sizes = [sizes_of(grid, terms) for grid in grids]
    carried: list[Arrays] = [
        {},
        *(carrying_matrices(*pair, terms=terms) for pair in pairwise(grids)),
    ]
    matrices = [
        {**carrying, **grid_matrices(grid, aspect=aspect, terms=terms)}
        for carrying, grid in zip(carried, grids, strict=True)
    ]
    alone = [{name: matrix[None] for name, matrix in each.items()} for each in matrices]
    absent = [*CARRYING, *(name for term in terms for name in term.CARRYING)]
    return (sizes[0][0], np.stack([values for _, values in sizes])), packed(alone, absent=absent)


def _in_results(batch: Batch, places: Sequence[_Place]) -> Columns:
    """Where each scene has its own, on each grid, and what a kernel is to know beside that."""
    begins, steps = [], []
    for stage, (means, states) in enumerate(places):
        guessed = stage == 0 and batch.guess is not None
        begins.append([means.start, states.start if states else ABSENT, guessed])
        steps.append([_step(means, batch), _step(states, batch) if states else 0, 0])
    names = ("means", "state", "guessed", "largest_state")
    values = np.empty((len(batch), len(places), len(names)), dtype=np.int64)
    values[..., :-1] = begins + np.multiply.outer(np.arange(len(batch)), steps)
    values[..., -1] = batch.largest_state
    return names, values


def _step(some: slice, batch: Batch) -> int:
    return int((some.stop - some.start) // len(batch))


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
    solve_batch([replace(scene, hv_m=0.0)], grid, tolerance=1.0, device=device)

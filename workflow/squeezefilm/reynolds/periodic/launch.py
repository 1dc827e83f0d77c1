"""The periodic state on the device: scenes of like terms on grids of their own (periodic.cl)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate
from typing import Any

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.lazy import cl
from squeezefilm.reynolds.device import (
    ALIGNMENT_BYTES,
    PADDING_DOUBLES,
    Device,
    compiled_kernel,
    run_kernel,
)
from squeezefilm.reynolds.error_estimate import resolved_change
from squeezefilm.reynolds.grid import (
    INTERPOLATION_MATRIX_NAMES,
    Grid,
    grid_matrices,
    interpolation_matrices,
    krylov_iteration_flops,
)
from squeezefilm.reynolds.layout import (
    ABSENT_INDEX,
    NamedIntegerColumns,
    PackedArrays,
    c_hook_calls,
    c_struct,
    fill_absent_numbers,
    kernel_rows,
    pack_arrays,
)
from squeezefilm.reynolds.packing import (
    common_terms,
    equation_numbers_table,
    mean_gap_motion,
    packed_profiles,
)
from squeezefilm.reynolds.periodic.time_modes import time_modes_of_films
from squeezefilm.reynolds.terms import (
    SWITCHABLE_TERM_NAMES,
    Terms,
    compiled_terms,
    flow_axis_count,
    flow_term_count,
    have_velocity_terms,
    is_radial,
    preconditioner_count,
    terms_of,
    unknown_field_count,
    work_field_count,
)
from squeezefilm.reynolds.terms.edge_pressure import EdgePressure

MAX_NEWTON_STEPS = 40
MIN_KRYLOV_ITERATIONS, MAX_KRYLOV_ITERATIONS = 20, 80
MAX_WORKSPACE_BYTES = 256 * 2**20
# Numbers between the terms' fields, of which a loop takes twenty: where they are a multiple of
# 4 KiB apart, as with 16 × 16 × 12 unknowns, few fit the first cache together.
FIELD_PADDING = 16
# Operations that a scene may take; half of them on one grid. One core does 4e9 to 2e10 a second. Of
# the films of verification/films.py, those that are solved take up to 2e11 (Re 5, σ 1, at 1e-5).
MAX_OPERATIONS = 5e11

# How an iteration ends: the kernel's names, and what is said of it.
STATUS_OF_ENDING_NAME = {
    "CONVERGED": "ok",
    "STALLED": "not converged: Newton's method",
    "NOT_FINITE": "not converged: the pressure became infinite",
    "OVER_LIMIT": f"not converged: no state within {MAX_OPERATIONS:.0e} operations",
}
STATUS_TEXTS = tuple(STATUS_OF_ENDING_NAME.values())

# What the device says of a scene on a grid beside its gauge pressure: a row of its results. The
# host adds what of a change the grids resolve.
RESULT_DTYPE = np.dtype(
    [
        *((name, np.float64) for name in ("mean", "residual", "largest", "lowest")),
        *((name, np.float64) for name in ("moment", "size", "resolved")),
        *((name, np.int64) for name in ("status", "newton_steps", "krylov_iterations")),
    ]
)

# Where the means in time of a batch's scenes on a grid begin, one behind the other, and the size of
# each; and their states, ABSENT_INDEX and 0 where these do not come back.
RESULT_SPAN_DTYPE = np.dtype(
    [(name, np.int64) for name in ("means", "means_size", "state", "state_size")]
)


@dataclass(frozen=True, eq=False)
class PeriodicStates:
    """Periodic states of scenes on one grid, on the host; ``states[k]`` is that of one of them.

    Attributes:
        unknowns: p = P − 1 in units of the ambient pressure and the terms' own unknowns, shape
            (scenes, fields, nx, ny, nt), of one scene (fields, nx, ny, nt); without fields where
            the batch does not ask for them.
        result_rows: rows of what the device says of the scenes, RESULT_DTYPE.
    """

    grid: Grid
    unknowns: np.ndarray
    result_rows: np.ndarray

    def __getitem__(self, rows: Any) -> PeriodicStates:
        return PeriodicStates(self.grid, self.unknowns[rows], self.result_rows[rows])

    def copy(self) -> PeriodicStates:
        """The same in memory of their own, for the arrays of a launch are used again."""
        return PeriodicStates(self.grid, self.unknowns.copy(), self.result_rows.copy())

    @property
    def gauge_pressure_ratio(self) -> np.ndarray:
        """p, shape (scenes, nx, ny, nt)."""
        return self.unknowns[:, 0]

    @property
    def mean_pressure_ratio(self) -> np.ndarray:
        """Mean of p over film and period, the force in units of p0 × area."""
        return self.result_rows["mean"]

    @property
    def status_indices(self) -> np.ndarray:
        """Index into STATUS_TEXTS."""
        return self.result_rows["status"]


@lru_cache(maxsize=256)
def _max_krylov_iterations(grid: Grid, terms: Terms) -> int:
    """Krylov iterations that a Newton step may take: as many as there is room for.

    Where their vectors will stand, perhaps of single precision, there is room for eight matrices
    in time (thermal_over_period.cl).
    """
    room = MAX_WORKSPACE_BYTES // (8 * grid.unknown_count * unknown_field_count(terms)) - 8
    least = max(MIN_KRYLOV_ITERATIONS, -(-16 * (grid.nt + 1) // (grid.nx * grid.ny)))
    return max(min(room, MAX_KRYLOV_ITERATIONS), least)


@lru_cache(maxsize=64)
def _grid_size_columns(
    grids: tuple[Grid, ...], terms: Terms, compiled: Terms, guessed: bool
) -> NamedIntegerColumns:
    """Return the sizes of each grid, by which a kernel finds everything else."""
    sizes = (
        *("nx", "ny", "nt", "most_krylov", "most_iterations"),
        *("whole_x", "whole_y", "whole_modes_x", "around"),
        *("guessed", "largest_state", "unknown_fields", "flow_terms"),
    )
    own = {term.NAME for term in terms}
    switched = [term.NAME for term in compiled if term.NAME in SWITCHABLE_TERM_NAMES]
    fields, flow_terms = unknown_field_count(terms), flow_term_count(terms)
    largest = fields * max(grid.unknown_count for grid in grids)
    breaks_x = any("x" in term.SYMMETRY_BROKEN_AXES for term in terms)
    values = [
        (
            *grid.space_time_shape,
            _max_krylov_iterations(grid, terms),
            MAX_OPERATIONS / 2 / krylov_iteration_flops(grid, terms),
            grid.x.uses_even_odd_parts,
            grid.y.uses_even_odd_parts,
            grid.x.uses_even_odd_parts and not (breaks_x and grid.outline is None),
            grid.outline is not None and grid.outline.jacobian_varies_more_with_nu,
            guessed and stage == 0,
            largest,
            fields,
            flow_terms,
            *(name in own for name in switched),
        )
        for stage, grid in enumerate(grids)
    ]
    return (*sizes, *(f"has_{name}" for name in switched)), np.array(values, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Batch:
    """Scenes on one grid after the other: the state on each is the first guess on the next.

    Attributes:
        all_scenes, scene_rows: some scenes, and which of these go together: all of one pad shape.
        terms: those that all of them have.
        grids: each no coarser than the one before; the change to the last tells its error.
        tolerances: relative error of the force that the iteration may leave, on each grid.
        initial_guess: first guess of the state on the first grid, shape (scenes, fields, nx, ny,
            nt); the film at rest by default.
        returns_every_grid: whether the states on all grids are asked for, and not that on the last
            alone.
        edge_fields: on a single grid, what a given pressure on the edge adds
            (terms/edge_pressure.py), by the arrays' names, shape (scenes, nx, ny, nt) each;
            ``terms`` have EdgePressure then.
        many: whether they are among many that are solved (``compiled_terms``).
    """

    all_scenes: Scenes
    scene_rows: np.ndarray
    terms: Terms
    grids: tuple[Grid, ...]
    tolerances: Sequence[float]
    initial_guess: np.ndarray | None = None
    returns_every_grid: bool = True
    edge_fields: Mapping[str, np.ndarray] | None = None
    many: bool = False

    def __len__(self) -> int:
        return len(self.scene_rows)

    @cached_property
    def scenes(self) -> Scenes:
        """The scenes that go together; all of them themselves, for those know their numbers."""
        whole = (
            len(self) == len(self.all_scenes) and (self.scene_rows == np.arange(len(self))).all()
        )
        return self.all_scenes if whole else self.all_scenes[self.scene_rows]

    @property
    def program(self) -> tuple[Terms, bool]:
        """The terms of the program that solves them, and whether GMRES is in single precision."""
        return compiled_terms(self.terms, many=self.many), uses_single_precision(self.terms)

    @property
    def aspect(self) -> float:
        """Aspect ratio of their pads."""
        pad = self.all_scenes.films[self.all_scenes.film_index[self.scene_rows[0]]].pad
        return pad.length_y_m / pad.length_x_m

    def __getitem__(self, part: slice | np.ndarray) -> Batch:
        guess = None if self.initial_guess is None else self.initial_guess[part]
        return replace(self, scene_rows=self.scene_rows[part], initial_guess=guess)

    @classmethod
    def join_batches(cls, batches: Sequence[Batch]) -> Batch:
        """Batches that go together as one."""
        first = batches[0]
        if len(batches) == 1:
            return first
        guess = None
        if first.initial_guess is not None:
            guess = np.concatenate([batch.initial_guess for batch in batches])
        return replace(
            first,
            scene_rows=np.concatenate([batch.scene_rows for batch in batches]),
            initial_guess=guess,
        )


@lru_cache(maxsize=256)
def _workspace_doubles(
    grid: Grid, terms: Terms, compiled: Terms, flow_terms: int, *, single: bool
) -> int:
    """Fields, Krylov basis, Hessenberg matrix of a grid, and its state twice."""
    most, fields = _max_krylov_iterations(grid, terms), unknown_field_count(terms)
    own = 2 * flow_terms + 3
    of_terms = work_field_count(compiled, single=single) * (grid.unknown_count + FIELD_PADDING)
    linear = 3 * flow_terms + 10 + (most + 1) * fields
    matrices = (3 + 6 * have_velocity_terms(terms)) * (grid.nx**2 + grid.ny**2 + grid.nt**2)
    if grid.outline:
        matrices += 2 * grid.nx * grid.ny * max(grid.nx, grid.ny) + 32
    small = (most + 4) * (most + 1) + grid.nx * grid.ny
    return grid.unknown_count * (own + linear + 2 * fields) + of_terms + matrices + small


def solve_batch(
    scenes: Scenes | Sequence[Scene],
    grid: Grid,
    *,
    tolerance: float,
    device: Device,
    guess: np.ndarray | None = None,
    edge: Mapping[str, np.ndarray] | None = None,
    terms: Terms | None = None,
    most_newton: int = MAX_NEWTON_STEPS,
    many: bool = False,
) -> PeriodicStates:
    """The periodic states of scenes of one pad shape and like terms on one grid.

    Args:
        guess, edge, many: as of a ``Batch``.
        terms: those that all scenes have, where they are known.
        most_newton: steps of Newton's method.

    Raises:
        ValueError: for scenes of unlike terms.
    """
    scenes = Scenes.of(scenes)
    terms = common_terms(scenes) if terms is None else terms
    if edge is not None:
        terms = (EdgePressure(), *terms)
    rows = np.arange(len(scenes))
    batch = Batch(scenes, rows, terms, (grid,), [tolerance], guess, edge_fields=edge, many=many)
    launched = launch([batch], device=device, most_newton=most_newton)
    (((states,),)) = launched.wait_for_states(device)
    kept = states.copy()
    device.recycle_arrays(*launched.pooled_host_arrays)
    return kept


@dataclass(eq=False)
class Launch:
    """Batches that the device is solving, and their arrays, as periodic.cl describes them.

    Attributes:
        row_dtype: the type of ``kernel_rows``.
        host_results: room for what the device says of the scenes, and their first guesses. It
            begins with what is said in rows; kernels read states in vectors.
        result_spans: RESULT_SPAN_DTYPE of each batch on each of its grids.
        pooled_host_arrays: what ``input_values`` and ``host_results`` are the beginnings of, of the
            device's pool.
        results_buffer: the device's of ``host_results``.
        kernel_event: the kernel's event.
    """

    batches: Sequence[Batch]
    first_row_indices: np.ndarray
    row_dtype: np.dtype[Any]
    kernel_rows: np.ndarray
    input_values: np.ndarray
    host_results: np.ndarray
    result_spans: Sequence[np.ndarray]
    pooled_host_arrays: Sequence[np.ndarray]
    results_buffer: Any = None
    kernel_event: Any = None

    def wait_for_states(self, device: Device) -> list[list[PeriodicStates]]:
        """Wait for the device; the states of each batch on each of its grids."""
        device.fetch_buffer(self.host_results, self.results_buffer, after=self.kernel_event)
        numbers = RESULT_DTYPE.itemsize // 8
        rows_of_results = (
            self.host_results[: len(self.kernel_rows) * numbers]
            .reshape(-1, numbers)
            .view(RESULT_DTYPE)[:, 0]
        )
        states: list[list[PeriodicStates]] = []
        first = 0
        for batch, spans in zip(self.batches, self.result_spans, strict=True):
            count, stages = len(batch.scenes), len(batch.grids)
            of_batch = []
            mean_pressures: list[tuple[Grid, np.ndarray]] = []
            for stage, (grid, span) in enumerate(zip(batch.grids, spans.tolist(), strict=True)):
                begin, means_size, state, size = span
                unknowns = self.host_results[state : state + count * size]
                of_scenes = rows_of_results[first + stage : first + count * stages : stages]
                means = self.host_results[begin : begin + count * means_size]
                mean_pressures.append((grid, means.reshape(count, grid.nx, grid.ny)))
                of_batch.append(
                    PeriodicStates(
                        grid, unknowns.reshape(count, -1, *grid.space_time_shape), of_scenes
                    )
                )
            if stages > 1 and have_velocity_terms(batch.terms):
                of_scenes["resolved"] = resolved_change(*mean_pressures[-2:])
            states.append(of_batch)
            first += count * stages
        return states


@lru_cache(maxsize=64)
def uses_single_precision(terms: Terms) -> bool:
    """Return whether GMRES works in single precision.

    Residual and state are double, so that only its steps are rounded. Most terms' own lines in the
    linear system are written for doubles.
    """
    return all(
        term.SUPPORTS_SINGLE_PRECISION or "response" not in term.KERNEL_HOOKS for term in terms
    )


@lru_cache(maxsize=64)
def program_source_files(terms: Terms, *, single: bool) -> tuple[str, ...]:
    """Files that a program of some terms is made of, in order."""
    own = [term.KERNEL_FILE for term in terms if term.KERNEL_FILE]
    vectors = ["vectors.cl"] * (2 if single else 1)
    grid = ["linear_algebra.cl", *vectors, "periodic/grid_over_period.cl"]
    return (*grid, *own, "periodic/film_over_period.cl", "krylov.cl", "periodic/periodic.cl")


def launch(
    batches: Sequence[Batch], *, device: Device, most_newton: int = MAX_NEWTON_STEPS
) -> Launch:
    """Let the device solve batches of one program; each scene is solved on its own.

    All of a scene's grids come in one launch, for the way to the device and back costs as much as
    a small solve.

    The device takes scenes in the given order: put the dearest first.

    Raises:
        InputError: where compiling the kernel would take so long that it looks like a fault, and
            in a process forked from the device's.
    """
    device.check_process()
    terms = batches[0].terms
    if device.loops_over_work_items and work_field_count(terms):
        raise InputError(
            f"PoCL may compile {' and '.join(term.label for term in terms)} for work-groups of "
            f"{device.work_items_per_group} items for many minutes: take one item, as a "
            f"processor is given "
            "where none are asked for"
        )
    launched = _packed_launch(batches, device)
    compiled, single = batches[0].program
    periodic_state = compiled_kernel(
        device,
        "periodic_state",
        sources=program_source_files(compiled, single=single),
        header=_program_header(compiled, launched.row_dtype, single=single),
    )
    (flow_terms,) = launched.row_dtype["flow"].shape
    sizes = [
        _workspace_doubles(grid, batch.terms, compiled, flow_terms, single=single)
        for batch in batches
        for grid in batch.grids
    ]
    workspace_size = -(-max(sizes) // 8) * 8
    scenes = len(launched.first_row_indices) - 1
    groups = device.work_group_count(scenes, workspace_bytes=8 * workspace_size)
    launched.results_buffer = device.shared_buffer(launched.host_results)
    launched.kernel_event = run_kernel(
        device,
        periodic_state,
        np.int32(scenes),
        np.int32(most_newton),
        device.copy_to_buffer(launched.first_row_indices),
        device.copy_to_buffer(launched.kernel_rows),
        device.shared_buffer(launched.input_values),
        launched.results_buffer,
        device.copy_to_buffer(np.zeros(1, dtype=np.int32)),
        device.workspace_buffer(workspace_size * groups),
        np.uint64(workspace_size),
        cl.LocalMemory(8 * device.work_items_per_group),
        groups=groups,
    )
    device.queue.flush()
    return launched


def _packed_launch(batches: Sequence[Batch], device: Device) -> Launch:
    """The batches' arrays behind each other, and where each scene's parts lie in them."""
    stages = [len(batch.grids) for batch in batches for _ in range(len(batch.scenes))]
    begins = np.array([0, *accumulate(stages)], dtype=np.int32)
    end = -(-int(begins[-1]) * RESULT_DTYPE.itemsize // ALIGNMENT_BYTES) * ALIGNMENT_BYTES // 8
    spans, rows, parts, size = [], [], [], 0
    for batch in batches:
        of_batch, end = _result_spans(batch, end)
        compiled, _ = batch.program
        numbers = equation_numbers_table(batch.scenes, batch.terms)
        columns = [
            (
                tuple(name for term in compiled for name in term.OPERATOR_NAMES),
                np.array(ABSENT_INDEX),
            ),
            _grid_size_columns(batch.grids, batch.terms, compiled, batch.initial_guess is not None),
        ]
        for name in ("means", "state"):
            behind = np.multiply.outer(np.arange(len(batch)), of_batch[f"{name}_size"])
            columns.append(((name,), (of_batch[name] + behind)[..., None]))
        for items, which in _arrays_of_batch(batch, numbers):
            begin = items.start_indices + size
            if which is not None:
                begin = begin + (which * items.packed_rows.shape[1])[:, None, None]
            columns.append((items.array_names, begin))
            parts.append(items.packed_rows.ravel())
            size += items.packed_rows.size
        # A mass error w moves the pressure by w/H.
        tolerance = np.multiply.outer(batch.scenes.narrowest_gap_ratio, batch.tolerances)
        numbers = fill_absent_numbers(numbers, compiled)
        kind, table = kernel_rows(columns, numbers=numbers, tolerance=tolerance)
        spans.append(of_batch)
        rows.append(table)
    arrays = device.host_array(end + PADDING_DOUBLES), device.host_array(size + PADDING_DOUBLES)
    results, values = arrays[0][: end + PADDING_DOUBLES], arrays[1][: size + PADDING_DOUBLES]
    np.concatenate(parts, out=values[:size])
    for batch, of_batch in zip(batches, spans, strict=True):
        if batch.initial_guess is not None:
            state = int(of_batch["state"][0])
            results[state : state + batch.initial_guess.size] = batch.initial_guess.ravel()
    table = rows[0] if len(rows) == 1 else np.concatenate(rows)
    return Launch(batches, begins, kind, table, values, results, spans, arrays)


def _result_spans(batch: Batch, end: int) -> tuple[np.ndarray, int]:
    """The spans of a batch whose results begin at some place, and where they end."""
    spans = []
    for stage, grid in enumerate(batch.grids):
        # A first guess lies where the state comes back.
        guess = stage == 0 and batch.initial_guess is not None
        returns = batch.returns_every_grid or guess or grid is batch.grids[-1]
        means, state = (
            grid.nx * grid.ny,
            unknown_field_count(batch.terms) * grid.unknown_count * returns,
        )
        # States begin where kernels can read four numbers at once.
        behind = -(-(end + len(batch.scenes) * means) // 4) * 4
        spans.append((end, means, behind if returns else ABSENT_INDEX, state))
        end = behind + len(batch.scenes) * state
    return np.array(spans, dtype=RESULT_SPAN_DTYPE), end


def _arrays_of_batch(
    batch: Batch, numbers: np.ndarray
) -> Iterator[tuple[PackedArrays, np.ndarray | None]]:
    """A batch's arrays on each grid, and which of them each scene has; None where all have one."""
    grids, terms, aspect = batch.grids, batch.terms, batch.aspect
    yield _matrices_of_grids(grids, terms, batch.program[0], aspect), None
    fields, at, means = packed_profiles(batch.scenes, grids, terms)
    yield fields, at
    yield time_modes_of_films(
        grids, aspect=aspect, numbers=numbers, motion=mean_gap_motion(numbers, means)
    )
    if batch.edge_fields is not None:
        yield pack_arrays([batch.edge_fields]), np.arange(len(batch.scenes))
    for term in terms:
        operators = [term.scene_operators(numbers, grid, aspect=aspect) for grid in grids]
        if operators[0]:
            yield pack_arrays(operators), np.arange(len(batch.scenes))


@lru_cache(maxsize=64)
def _matrices_of_grids(
    grids: tuple[Grid, ...], terms: Terms, compiled: Terms, aspect: float
) -> PackedArrays:
    """The matrices of some grids, with those that carry a state to the next."""
    stages: list[dict[str, np.ndarray]] = []
    for coarse, grid in zip((None, *grids), grids, strict=False):
        carrying = interpolation_matrices(coarse, grid, terms=terms) if coarse else {}
        matrices = {**carrying, **grid_matrices(grid, aspect=aspect, terms=terms)}
        stages.append({name: matrix[None] for name, matrix in matrices.items()})
    absent = [
        *INTERPOLATION_MATRIX_NAMES,
        *(name for term in compiled for name in term.INTERPOLATION_MATRIX_NAMES),
    ]
    return pack_arrays(stages, absent=absent)


@lru_cache(maxsize=64)
def _program_header(terms: Terms, row: np.dtype[Any], *, single: bool) -> str:
    """Return the definitions for the sources of a program of some terms."""
    (flow_terms,) = row["flow"].shape
    # Compilers unroll what they know.
    known = flow_terms == 1 or not work_field_count(terms)
    return "\n".join(
        [
            f"#define FLOW_TERMS {flow_terms}",
            f"#define FLOW_TERMS_OF(film) {flow_terms if known else '((film)->row->flow_terms)'}",
            f"#define AXES {flow_axis_count(terms)}",
            f"#define ROW_PARTS {preconditioner_count(terms)}",
            f"#define OWN_FIELDS {work_field_count(terms, single=single)}",
            f"#define FIELD_PADDING {FIELD_PADDING}",
            "#define SINGLE" if single else "",
            *(f"#define HAS_{term.NAME}" for term in terms),
            c_struct("Row", row),
            c_struct("Said", RESULT_DTYPE),
            f"enum {{ {', '.join(STATUS_OF_ENDING_NAME)} }};",
            c_hook_calls(terms),
        ]
    )


def grid_on_pad(scene: Scene, points: Grid) -> Grid:
    """A rectangle's grid in the coordinates of a scene's pad; along the radius of a film without
    angle.
    """
    if is_radial(terms_of(scene)):
        return replace(points, ny=1, fold_x=True, fold_y=True)
    return replace(points, outline=scene.pad.smooth_outline)


def build_kernels_for_scene(device: Device, scene: Scene, *, many: bool) -> None:
    """Build and load the kernels that a scene, or many like it, needs before the first batch."""
    grid = grid_on_pad(scene, Grid(4, 4, 8, False, False))
    solve_batch([replace(scene, hv_m=0.0)], grid, tolerance=1.0, device=device, many=many)

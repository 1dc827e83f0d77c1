"""Definitions that kernels and Python share: rows of numbers, endings, terms' hooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from squeezefilm.reynolds.terms import KERNEL_HOOK_PARAMETERS, Terms

C_TYPES = {"float64": "double", "int64": "long"}
# Index of an array that is absent; it stays below zero whatever is added to it.
ABSENT_INDEX = -(2**62)


def c_struct(name: str, row: np.dtype[Any]) -> str:
    """A structured type of 8-byte numbers as a C struct of the same layout."""
    members = []
    for member in row.names or ():
        base, shape = row[member].base, row[member].shape
        counts = "".join(f"[{count}]" for count in shape)
        members.append(f"{C_TYPES[base.name]} {member}{counts};")
    return f"typedef struct {{ {' '.join(members)} }} {name};"


def fill_absent_numbers(numbers: np.ndarray, terms: Terms) -> np.ndarray:
    """Return rows of numbers with all that a program's terms have; what a film lacks is 0."""
    kind = _row_type_in_program(numbers.dtype, terms)
    if kind == numbers.dtype:
        return numbers
    wide = np.zeros(len(numbers), dtype=kind)
    for name in numbers.dtype.names or ():
        own = numbers[name]
        if own.ndim > 1:
            wide[name][:, : own.shape[1]] = own
        else:
            wide[name] = own
    return wide


@lru_cache(maxsize=64)
def _row_type_in_program(own: np.dtype[Any], terms: Terms) -> np.dtype[Any]:
    kinds = {name: own[name] for name in own.names or ()}
    for term in terms:
        for name, count in term.EQUATION_NUMBER_WIDTHS.items():
            kinds[name] = np.dtype((np.float64, (count,) if count else ()))
    return np.dtype(sorted(kinds.items()))


def c_hook_calls(terms: Terms) -> str:
    """Every hook of the equation as the calls of the terms that fill it."""
    lines = []
    for hook, parameters in KERNEL_HOOK_PARAMETERS.items():
        calls = [f"{hook}_{term.NAME}{parameters};" for term in terms if hook in term.KERNEL_HOOKS]
        lines.append(f"#define TERMS_{hook.upper()}{parameters} {' '.join(calls)}")
    return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class PackedArrays:
    """Arrays of like items behind each other, a row for each item.

    Attributes:
        array_names: of the arrays.
        packed_rows: shape (items, size of a row).
        start_indices: where each begins in its row, on each stage: shape (stages, names).
    """

    array_names: tuple[str, ...]
    packed_rows: np.ndarray
    start_indices: np.ndarray

    @classmethod
    def join_rows(cls, parts: Sequence[PackedArrays]) -> PackedArrays:
        """Join several packed tables with equal arrays."""
        if len(parts) == 1:
            return parts[0]
        return cls(
            parts[0].array_names,
            np.concatenate([packed.packed_rows for packed in parts]),
            parts[0].start_indices,
        )


def pack_arrays(
    stages: Sequence[Mapping[str, np.ndarray]], *, absent: Sequence[str] = ()
) -> PackedArrays:
    """Arrays whose first axis counts items, under the same names on every stage.

    Each begins where kernels can read four numbers at once.

    Args:
        absent: names that some stages lack.
    """
    names = tuple(dict.fromkeys([*absent, *stages[-1]]))
    count = len(next(iter(stages[-1].values())))
    starts = np.full((len(stages), len(names)), ABSENT_INDEX)
    places, end = [], 0
    for stage, arrays in enumerate(stages):
        for name, array in arrays.items():
            size = array.size // count
            starts[stage, names.index(name)] = end
            places.append((slice(end, end + size), array))
            end += -(-size // 4) * 4
    values = np.zeros((count, end))
    for place, array in places:
        # A view: only the rows are apart.
        values[:, place].reshape(count, *array.shape[1:])[...] = array
    return PackedArrays(names, values, starts)


NamedIntegerColumns = tuple[tuple[str, ...], np.ndarray]
"""Names of whole numbers, and these: the same for all scenes, for each stage or for each scene and
stage, of shape (names,), (stages, names) or (scenes, stages, names)."""


def kernel_rows(
    columns: Sequence[NamedIntegerColumns], *, numbers: np.ndarray, tolerance: np.ndarray
) -> tuple[np.dtype[Any], np.ndarray]:
    """Rows for a kernel, scene by scene one for each stage, as plain numbers, and their type.

    Args:
        columns: whole numbers, of names that there are twice the last counts.
        numbers: with a row per scene.
        tolerance: of each scene on each stage, (scenes, stages).
    """
    names, whole = zip(*columns, strict=True)
    kind, column_indices = _kernel_row_type(names, numbers.dtype)
    table = np.empty((*tolerance.shape, kind.itemsize // 8), dtype=np.int64)
    for indices, values in zip(column_indices, whole, strict=True):
        table[:, :, indices] = values
    reals = table.view(np.float64)
    reals[..., -1 - numbers.itemsize // 8 : -1] = numbers.view(np.float64).reshape(
        len(numbers), 1, -1
    )
    reals[..., -1] = tolerance
    return kind, table.reshape(-1, table.shape[-1])


@lru_cache(maxsize=64)
def _kernel_row_type(
    whole: tuple[tuple[str, ...], ...], numbers: np.dtype[Any]
) -> tuple[np.dtype[Any], list[list[int]]]:
    """Return the row type, and the columns of each of ``whole`` among its plain numbers."""
    names = sorted({name for names_of_array in whole for name in names_of_array})
    kinds = [*((name, np.int64) for name in names), *numbers.descr, ("tolerance", np.float64)]
    return np.dtype(kinds), [
        [names.index(name) for name in names_of_array] for names_of_array in whole
    ]

"""What kernels and Python both know, defined once here: rows of numbers, endings, terms' hooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import accumulate
from typing import Any

import numpy as np

from squeezefilm.reynolds.device import PADDING
from squeezefilm.reynolds.terms import HOOKS, Terms

C_TYPES = {"float64": "double", "int64": "long"}
# What stands for no place; it stays below zero whatever is added to it.
NOTHING = -(2**62)


def c_struct(name: str, row: np.dtype[Any]) -> str:
    """A structured type of 8-byte numbers as a C struct of the same layout."""
    members = []
    for member in row.names or ():
        base, shape = row[member].base, row[member].shape
        counts = "".join(f"[{count}]" for count in shape)
        members.append(f"{C_TYPES[base.name]} {member}{counts};")
    return f"typedef struct {{ {' '.join(members)} }} {name};"


def c_enum(names: Iterable[str]) -> str:
    return f"enum {{ {', '.join(names)} }};"


def c_terms(terms: Terms) -> str:
    """Every hook of the equation as the calls of the terms that fill it."""
    lines = []
    for hook, parameters in HOOKS.items():
        calls = [f"{hook}_{term.NAME}{parameters};" for term in terms if hook in term.HOOKS]
        lines.append(f"#define TERMS_{hook.upper()}{parameters} {' '.join(calls)}")
    return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Columns:
    """Whole numbers in rows, of which a scene has one for each stage of its way.

    Attributes:
        names: of the columns.
        values: the same for all, for each stage or for each row: shape (names,), (stages, names)
            or (scenes, stages, names).
    """

    names: tuple[str, ...]
    values: np.ndarray


def rows_of(
    columns: Sequence[Columns],
    *,
    numbers: np.ndarray,
    stages: int = 1,
    **more: np.ndarray | Sequence[float],
) -> np.ndarray:
    """Rows for a kernel, scene by scene one for each stage: whole numbers, the scene's, and more.

    Args:
        columns: whole numbers, of names that there are twice the last counts.
        numbers: with a row per scene.
        more: one for each scene, shape (scenes,), or for each of its rows, (scenes, stages).
    """
    kind, places = _row_type(tuple(each.names for each in columns), numbers.dtype, tuple(more))
    # As plain numbers, and many columns at once: a row has some thirty.
    table = np.empty((len(numbers), stages, kind.itemsize // 8), dtype=np.int64)
    for place, each in zip(places, columns, strict=False):
        table[:, :, place] = each.values
    reals = table.view(np.float64)
    if numbers.dtype.itemsize:
        reals[..., places[-1]] = numbers.view(np.float64).reshape(len(numbers), 1, -1)
    for column, values in enumerate(more.values(), start=reals.shape[-1] - len(more)):
        reals[..., column] = np.reshape(values, (len(numbers), -1))
    return table.reshape(-1, table.shape[-1]).view(kind)[:, 0]


def by_stages(stages: Sequence[Columns]) -> Columns:
    """Those of the scenes on each stage, shapes (scenes, 1, names), as one."""
    return Columns(stages[0].names, np.concatenate([each.values for each in stages], axis=1))


def joined_rows(batches: Sequence[np.ndarray]) -> np.ndarray:
    """The rows of several batches as one array."""
    # As plain numbers: NumPy is slow to find that structured types are the same.
    return np.concatenate([rows.view(np.int64) for rows in batches]).view(batches[0].dtype)


@lru_cache(maxsize=64)
def _row_type(
    whole: tuple[tuple[str, ...], ...], numbers: np.dtype[Any], more: tuple[str, ...]
) -> tuple[np.dtype[Any], list[slice | list[int]]]:
    """The rows' type, and where among their plain numbers each of ``whole`` lies, then numbers."""
    names = list(dict.fromkeys(name for some in whole for name in some))
    kinds = (
        [(name, np.int64) for name in names],
        numbers.descr if numbers.itemsize else [],
        [(name, np.float64) for name in more],
    )
    places: list[slice | list[int]] = []
    for some in whole:
        found = [names.index(name) for name in some]
        together = found == list(range(found[0], found[0] + len(found)))
        places.append(slice(found[0], found[0] + len(found)) if together else found)
    places.append(slice(len(names), len(names) + numbers.itemsize // 8))
    return np.dtype([kind for some in kinds for kind in some]), places


@dataclass(frozen=True, eq=False)
class Joined:
    """Arrays behind each other, and where each begins: shape (names,) or (stages, names)."""

    names: tuple[str, ...]
    values: np.ndarray
    starts: np.ndarray


def joined(parts: Mapping[str, np.ndarray]) -> Joined:
    """Arrays behind each other, each beginning where kernels can read four numbers at once."""
    pieces = [_in_fours(np.ascontiguousarray(part).ravel()) for part in parts.values()]
    return Joined(tuple(parts), np.concatenate(pieces), _begins(piece.size for piece in pieces))


def nothing(names: Sequence[str]) -> Joined:
    """Of arrays that there are not, as if they were there."""
    return Joined(tuple(names), np.empty(0), np.full(len(names), NOTHING))


def joined_stages(stages: Sequence[Sequence[Joined]]) -> Joined:
    """What there is of each stage, under the same names, behind what there is of the one before."""
    each = [some for stage in stages for some in stage]
    ends = iter(_begins(some.values.size for some in each))
    starts = [np.concatenate([some.starts + next(ends) for some in stage]) for stage in stages]
    names = tuple(name for some in stages[0] for name in some.names)
    return Joined(names, np.concatenate([some.values for some in each]), np.stack(starts))


def joined_each(stages: Sequence[Mapping[str, np.ndarray]]) -> list[Joined]:
    """Of each row of arrays that have as many rows, on every stage of the same names."""
    rows = [part.reshape(len(part), -1) for parts in stages for part in parts.values()]
    rows = [np.pad(part, ((0, 0), (0, -part.shape[1] % 4))) for part in rows]
    begins = _begins(part.shape[1] for part in rows).reshape(len(stages), -1)
    return [Joined(tuple(stages[0]), row, begins) for row in np.concatenate(rows, axis=1)]


def _begins(sizes: Iterable[int]) -> np.ndarray:
    """Where each of some arrays begins that lie behind each other."""
    return np.array([*accumulate(sizes, initial=0)][:-1])


def _in_fours(piece: np.ndarray) -> np.ndarray:
    left = -piece.size % 4
    return np.append(piece, np.zeros(left)) if left else piece


@dataclass
class Pile:
    """Arrays that are put behind each other for one launch."""

    parts: list[np.ndarray] = field(default_factory=list)
    end: int = 0

    def put(self, values: np.ndarray) -> int:
        """Where an array begins."""
        begin = self.end
        self.parts.append(values)
        self.end += values.size
        return begin

    def add(self, more: Joined) -> Columns:
        """Where each of some arrays begins."""
        return Columns(more.names, more.starts + self.put(more.values))

    def add_each(self, parts: Mapping[str, np.ndarray], which: np.ndarray | None = None) -> Columns:
        """Where each scene's part begins of arrays with a row for each scene, or for ``which``."""
        begins = [self.put(part.ravel()) for part in parts.values()]
        count = len(next(iter(parts.values())))
        sizes = [part.size // count for part in parts.values()]
        rows = np.arange(count) if which is None else which
        return Columns(tuple(parts), begins + np.multiply.outer(rows, [sizes]))

    @property
    def values(self) -> np.ndarray:
        """All of them, with padding behind the last."""
        return self.put_into(np.empty(self.end + PADDING))

    def put_into(self, room: np.ndarray) -> np.ndarray:
        """All of them at the beginning of some room."""
        np.concatenate(self.parts, out=room[: self.end])
        return room

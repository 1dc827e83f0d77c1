"""What kernels and Python both know, defined once here: rows of numbers, endings, terms' hooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import accumulate
from typing import Any

import numpy as np

from squeezefilm.reynolds.device import SPARE
from squeezefilm.reynolds.terms import HOOKS, Terms

C_TYPES = {"float64": "double", "int64": "long"}


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


def rows_of(
    whole: Mapping[str, int | np.ndarray], numbers: np.ndarray, **more: np.ndarray
) -> np.ndarray:
    """One row per scene for a kernel: whole numbers, the scene's own numbers, and more of them.

    Args:
        whole: for each name one for all scenes, or one for each.
        numbers: with a row per scene.
    """
    kind = _row_type(tuple(whole), numbers.dtype, tuple(more))
    table = np.empty((len(numbers), kind.itemsize // 8), dtype=np.int64)
    # As plain numbers, and at once what is one for all: a row has some thirty columns.
    table[:, : len(whole)] = [
        0 if isinstance(each, np.ndarray) else each for each in whole.values()
    ]
    for column, each in enumerate(whole.values()):
        if isinstance(each, np.ndarray):
            table[:, column] = each
    reals = table.view(np.float64)
    own = numbers.dtype.itemsize // 8
    if own:
        reals[:, len(whole) : len(whole) + own] = numbers.view(np.float64).reshape(-1, own)
    for column, each in enumerate(more.values(), start=len(whole) + own):
        reals[:, column] = each
    return table.view(kind)[:, 0]


def scene_by_scene(batches: Iterable[Sequence[np.ndarray]]) -> np.ndarray:
    """The rows of batches, each of which has arrays of one row per scene, one after the other."""
    kind, tables = np.dtype(np.int64), []
    for arrays in batches:
        kind = arrays[0].dtype
        # As plain numbers: NumPy is slow to find that structured types are the same.
        plain = [rows.view(np.int64).reshape(len(rows), -1) for rows in arrays]
        tables.append(np.stack(plain, axis=1).ravel())
    return np.concatenate(tables).view(kind)


@lru_cache(maxsize=64)
def _row_type(
    whole: tuple[str, ...], numbers: np.dtype[Any], more: tuple[str, ...]
) -> np.dtype[Any]:
    kinds = (
        [(name, np.int64) for name in whole],
        numbers.descr,
        [(name, np.float64) for name in more],
    )
    return np.dtype([kind for some in kinds for kind in some])


@dataclass(frozen=True, eq=False)
class Joined:
    """Arrays behind each other, and where each begins."""

    values: np.ndarray
    starts: dict[str, int]


def joined(parts: Mapping[str, np.ndarray]) -> Joined:
    pieces = [np.ascontiguousarray(part).ravel() for part in parts.values()]
    starts = accumulate((piece.size for piece in pieces[:-1]), initial=0)
    return Joined(np.concatenate(pieces), dict(zip(parts, starts, strict=True)))


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

    def add(self, more: Joined) -> dict[str, int]:
        """Where each of some arrays begins."""
        begin = self.put(more.values)
        return {name: begin + start for name, start in more.starts.items()}

    def add_each(
        self, parts: Mapping[str, np.ndarray], which: np.ndarray | None = None
    ) -> dict[str, np.ndarray]:
        """Where each scene's part begins of arrays with a row for each scene, or for ``which``."""
        starts = self.add(joined(parts)) if parts else {}
        places = {}
        for name, part in parts.items():
            rows = np.arange(len(part)) if which is None else which
            places[name] = starts[name] + part[0].size * rows
        return places

    @property
    def values(self) -> np.ndarray:
        """All of them, with room to spare behind the last."""
        return np.concatenate([*self.parts, np.zeros(SPARE)])

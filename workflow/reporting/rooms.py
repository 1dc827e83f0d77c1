"""What figures and tables say of themselves in literals: read here, without importing them."""

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from squeezefilm.io.errors import InputError


@dataclass(frozen=True)
class Room:
    """What the module of a figure, or of one of the paper's tables, says of itself.

    Attributes:
        module: its dotted name.
        title, shows, caption: ``Figure 8``, ``the model fitted to the screen``, the caption.
        inputs: the files it is made from by name, each with its place among a study's results.
        builds: whether its table is its own, or one that another stage makes.
    """

    module: str
    title: str
    shows: str
    caption: str
    inputs: dict[str, str]
    builds: bool

    @property
    def place(self) -> str:
        """Where it lies among the results, without a suffix; drawings lie beside their table."""
        if self.builds:
            return "/".join(self.module.split(".")[-2:])
        return next(iter(self.inputs.values())).rpartition(".")[0]


def described(path: Path) -> Room:
    """What the module in a file says of itself; nothing is imported.

    Raises InputError naming the file and what it does not say.
    """
    tree = _parsed(path)
    line, _, caption = (ast.get_docstring(tree) or "").partition("\n\n")
    title, colon, shows = line.partition(": ")
    if not (colon and caption):
        raise InputError(
            f"{path}: a figure's docstring says `Name: what it shows.` and, below, its caption"
        )
    inputs = literal(path, "INPUTS")
    if inputs is None:
        raise InputError(f"{path}: a figure says what it is made from in INPUTS")
    builds = any(isinstance(node, ast.FunctionDef) and node.name == "build" for node in tree.body)
    if not builds and len(inputs) != 1:
        raise InputError(f"{path}: a figure without `build` is drawn from one table")
    return Room(
        module=".".join((*path.parent.parts[-2:], path.stem)),
        title=title,
        shows=" ".join(shows.split()).removesuffix("."),
        caption=" ".join(caption.split()),
        inputs=inputs,
        builds=builds,
    )


def literal(path: Path, name: str) -> Any:
    """The value that a module in a file gives a name of its own, or None where it gives none.

    Raises InputError where the value is no plain literal.
    """
    for node in _parsed(path).body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        if isinstance(target, ast.Name) and target.id == name:
            try:
                return ast.literal_eval(node.value)  # type: ignore[attr-defined]
            except ValueError:
                raise InputError(f"{path}: {name} must be a plain literal") from None
    return None


@cache
def _parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))

"""Which files decide what a command does: found by reading the code, without running it.

Snakemake follows neither imports nor kernels, so each rule names these files as its input. They
are the modules that the command imports, directly or not, at the top of a module or inside a
function, and the data files and OpenCL kernels that such a module names by a text constant,
with whatever a kernel includes.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from squeezefilm.io.errors import InputError

WORKFLOW = Path(__file__).resolve().parents[2]
COMMANDS = ("squeezefilm/cli/*", "*/commands")
"""Folders of the packages that hold commands."""

INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)


def code_of(command: str, *modules: str) -> list[Path]:
    """The files that ``squeezefilm COMMAND`` depends on, sorted.

    ``modules`` are those which the command loads by a name made at run time:
    ``"paper.figures.fig08"``.

    Raises:
        InputError: for a command or module that does not exist, or one that is not valid Python.
    """
    own = command_module(command)
    roots = (f"{own.partition('.')[0]}.__main__", own, *modules)
    return sorted(_reached_from(tuple(_existing(root) for root in roots)))


def command_module(command: str) -> str:
    """The dotted name of a command's module, in whichever package it is.

    Raises:
        InputError: for a command that does not exist.
    """
    file = f"{command.replace('-', '_')}.py"
    for folder in COMMANDS:
        for path in WORKFLOW.glob(f"{folder}/{file}"):
            return ".".join(path.relative_to(WORKFLOW).with_suffix("").parts)
    raise InputError(f"there is no command {command!r}")


def sections_of(module: str, key: str | None = None) -> tuple[str, ...]:
    """The ``SECTIONS`` of the configuration that a module may read.

    ``key`` chooses where SECTIONS is a mapping. SECTIONS is a plain literal: it is read here
    without importing the module and all that it needs.

    Raises:
        InputError: when the module has no such literal, or no such key.
    """
    path = _existing(module)
    for node in _parse(path).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == "SECTIONS" for target in targets):
            try:
                value = ast.literal_eval(node.value)  # type: ignore[attr-defined]
                return tuple(value[key] if isinstance(value, dict) else value)
            except (ValueError, KeyError, TypeError):
                break
    raise InputError(f"{path}: SECTIONS must be a literal tuple of names, or one for {key!r}")


def may_read(section: str, *modules: str) -> bool:
    """Whether any of some modules names a section in its ``SECTIONS``.

    Where SECTIONS is a mapping, for one of its keys at least.
    """
    texts: set[str] = set()
    for module in modules:
        for node in _parse(_existing(module)).body:
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", 0)]
            if any(isinstance(name, ast.Name) and name.id == "SECTIONS" for name in targets):
                texts.update(
                    part.value
                    for part in ast.walk(node)
                    if isinstance(part, ast.Constant) and isinstance(part.value, str)
                )
    return section in texts


@cache
def _reached_from(roots: tuple[Path, ...]) -> frozenset[Path]:
    reached: set[Path] = set()
    waiting = list(roots)
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting.extend(_named_by(path))
    return frozenset(reached)


@cache
def _named_by(path: Path) -> frozenset[Path]:
    """The files that one file names: imported modules, data, kernels, includes."""
    if path.suffix == ".py":
        nodes = list(ast.walk(_parse(path)))
        return frozenset([*_imported(nodes, path), *_data_files(nodes)])
    if path.suffix in (".cl", ".h"):
        names = INCLUDE.findall(path.read_text(encoding="utf-8"))
        return frozenset(file for name in names for file in _data_named(name))
    return frozenset()


def _imported(nodes: Iterable[ast.AST], path: Path) -> Iterator[Path]:
    for node in nodes:
        if isinstance(node, ast.Import):
            for name in node.names:
                yield from _with_packages(name.name)
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(node, path)
            yield from _with_packages(base)
            for name in node.names:  # a name may be a module too: from squeezefilm import study
                yield from _with_packages(f"{base}.{name.name}")
    yield from _with_packages(".".join(path.relative_to(WORKFLOW).with_suffix("").parts))


def _absolute(node: ast.ImportFrom, path: Path) -> str:
    """The dotted name after ``from``, its leading dots resolved."""
    if not node.level:
        return node.module or ""
    package = path.relative_to(WORKFLOW).parent.parts
    parts = package[: len(package) - node.level + 1]
    return ".".join([*parts, *([node.module] if node.module else [])])


def _with_packages(name: str) -> Iterator[Path]:
    """The file of a module of ours, and those of the packages around it."""
    parts = name.split(".")
    if parts[0] in _packages():
        for length in range(1, len(parts) + 1):
            file = _file(".".join(parts[:length]))
            if file:
                yield file


def _file(name: str) -> Path | None:
    stem = WORKFLOW.joinpath(*name.split("."))
    for candidate in (stem.with_name(stem.name + ".py"), stem / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None


def _existing(name: str) -> Path:
    file = _file(name)
    if file is None:
        raise InputError(f"there is no module {name}")
    return file


def _data_files(nodes: Iterable[ast.AST]) -> Iterator[Path]:
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from _data_named(node.value)


def _data_named(name: str) -> list[Path]:
    return _all_data().get(name.rsplit("/", 1)[-1], [])


@cache
def _packages() -> frozenset[str]:
    return frozenset(path.parent.name for path in WORKFLOW.glob("*/__init__.py"))


@cache
def _all_data() -> dict[str, list[Path]]:
    """Every file of our packages and schemas that is not Python, by its name."""
    by_name: dict[str, list[Path]] = {}
    for folder in (*sorted(_packages()), "schemas"):
        for path in sorted((WORKFLOW / folder).rglob("*")):
            if path.is_file() and path.suffix not in (".py", ".pyc"):
                by_name.setdefault(path.name, []).append(path)
    return by_name


@cache
def _parse(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    except SyntaxError as error:
        raise InputError(f"{path}: line {error.lineno}: {error.msg}") from None

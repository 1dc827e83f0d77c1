"""What decides the numbers of a command: found by reading the code, without running it.

Snakemake follows neither imports nor kernels. What decides a command's numbers are the modules that
it imports, directly or not, at the top of a module or inside a function, those of a package whose
modules it finds by ``modules_in("package")``, and the data files and OpenCL kernels that such a
module names by a text constant, with whatever a kernel includes; each by a digest that comments,
docstrings and help texts do not change. What is in DECIDES_NOTHING is left out.
"""

import ast
import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from squeezefilm.io.atomic import digest, write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.job import remembered

WORKFLOW = Path(__file__).resolve().parents[2]
COMMANDS = ("squeezefilm/cli/*", "*/commands")
"""Folders of the packages that hold commands."""

DECIDES_NOTHING = {
    "*/__main__.py": "starts the command line",
    "squeezefilm/cli/main.py": "finds the command and hands it its words",
    "squeezefilm/io/job.py": "keeps a job's record, and ends a job that nobody wants any more",
    "squeezefilm/io/progress.py": "shows how far a command is",
    "squeezefilm/runs/locks.py": "says who makes a study",
    "squeezefilm/runs/node_cache.py": "says where compiled kernels are kept",
    "squeezefilm/runs/provenance.py": "writes down what made a file",
    "squeezefilm/studies/config.schema.yaml": "refuses a study, before any job",
}
"""Files that jobs use and that change no result, each with the reason."""

INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)
C_COMMENT = re.compile(r'("(?:\\.|[^"\\\n])*")|/\*.*?\*/|//[^\n]*', re.DOTALL)
ARGPARSE = {"ArgumentParser", "add_argument", "add_argument_group", "add_parser", "add_subparsers"}
HELP = {"description", "epilog", "help", "metavar", "title"}


@dataclass(frozen=True)
class Part:
    """What one file says: its digest, the modules and files it names, its ``SECTIONS``."""

    digest: str
    modules: Sequence[str]
    files: Sequence[str]
    sections: Any = None


class Code:
    """The code under ``root`` as it is at this moment.

    ``memory`` is a file that keeps what was found in each file, by its content: reading is quick,
    parsing is not.
    Raises InputError for a module that is not valid Python.
    """

    def __init__(self, root: Path = WORKFLOW, *, memory: Path | None = None) -> None:
        self.root = root
        self._packages = {path.parent.name for path in root.glob("*/__init__.py")}
        left_out = {path for pattern in DECIDES_NOTHING for path in root.glob(pattern)}
        paths = [
            path
            for folder in sorted(self._packages)
            for path in sorted((root / folder).rglob("*"))
            if path.is_file() and path.suffix != ".pyc" and path not in left_out
        ]
        self.parts = self._read(paths, memory)
        self._modules = {self._dotted(path): path for path in paths if path.suffix == ".py"}
        self._data: dict[str, list[Path]] = {}
        for path in paths:
            if path.suffix != ".py":
                self._data.setdefault(path.name, []).append(path)
        self._named: dict[Path, frozenset[Path]] = {}

    def of(self, command: str, *modules: str) -> list[Path]:
        """The files that decide the numbers of ``squeezefilm COMMAND``, sorted.

        ``modules`` are those which the command loads by a name made at run time:
        ``"paper.figures.fig08"``.
        Raises InputError for a command or module that does not exist.
        """
        return self.reached_from(self.command_module(command), *modules)

    def reached_from(self, *modules: str) -> list[Path]:
        """The files that decide what modules do, by their dotted names: theirs too, sorted."""
        waiting = [self._module(name) for name in modules]
        reached: set[Path] = set()
        while waiting:
            path = waiting.pop()
            if path not in reached:
                reached.add(path)
                waiting.extend(self._named_by(path))
        return sorted(reached)

    def command_module(self, command: str) -> str:
        """The dotted name of a command's module, in whichever package it is.

        Raises InputError for a command that does not exist.
        """
        for folder in COMMANDS:
            for path in self.root.glob(f"{folder}/{command.replace('-', '_')}.py"):
                return self._dotted(path)
        raise InputError(f"there is no command {command!r}")

    def sections(self, command: str, *modules: str, key: str | None = None) -> tuple[str, ...]:
        """The sections of the configuration that a command and some modules may read.

        They are the modules' ``SECTIONS``, plain literals, none where a module has none; ``key``
        chooses where one is a mapping.
        Raises InputError when it is no literal, or the command's has no such key.
        """
        own = self._module(self.command_module(command))
        found: list[str] = []
        for path in (own, *(self._module(name) for name in modules)):
            value = self.parts[path].sections
            value = value.get(key) if isinstance(value, dict) else value
            if value is None and path == own:
                raise InputError(
                    f"{path}: SECTIONS must be a literal tuple of names, or one for {key!r}"
                )
            found.extend(value or ())
        return tuple(dict.fromkeys(found))

    def _read(self, paths: list[Path], memory: Path | None) -> dict[Path, Part]:
        """What is in each file, as far as possible from what is remembered."""
        maker = digest(Path(__file__))
        known = remembered(memory).get(maker, {}) if memory else {}
        found = {}
        for path in paths:
            content = path.read_bytes()
            key = f"{path.relative_to(self.root)} {hashlib.sha256(content).hexdigest()}"
            found[key] = Part(**known[key]) if key in known else self._parse(path, content)
        if memory and found.keys() != known.keys():
            text = json.dumps({maker: {key: asdict(each) for key, each in found.items()}})
            with suppress(InputError):
                write_text(text, memory)
        return dict(zip(paths, found.values(), strict=True))

    def _parse(self, path: Path, content: bytes) -> Part:
        if path.suffix == ".py":
            try:
                tree = ast.parse(content)
            except SyntaxError as error:
                raise InputError(f"{path}: line {error.lineno}: {error.msg}") from None
            shape = repr(_shape(tree))
            nodes = list(_deciding(tree))
            modules = {*self._imported(nodes, path), self._dotted(path)}
            return Part(_sha256(shape), sorted(modules), _file_names(nodes), _sections(tree))
        if path.suffix in (".cl", ".h"):
            text = C_COMMENT.sub(lambda found: found[1] or " ", content.decode("utf-8"))
            lines = [line.split() for line in text.splitlines()]
            names = [name.rsplit("/", 1)[-1] for name in INCLUDE.findall(text)]
            return Part(_sha256(repr([words for words in lines if words])), [], names)
        return Part(hashlib.sha256(content).hexdigest(), [], [])

    def _imported(self, nodes: Iterable[ast.AST], path: Path) -> Iterator[str]:
        """The names that may be modules of ours: ``from squeezefilm import study`` too."""
        for node in nodes:
            names = []
            if isinstance(node, ast.Import):
                names = [name.name for name in node.names]
            elif isinstance(node, ast.ImportFrom):
                base = self._absolute(node, path)
                names = [base, *(f"{base}.{name.name}" for name in node.names)]
            elif _callee(node) == "modules_in":
                places = [getattr(each, "value", "") for each in getattr(node, "args", ())]
                names = [f"{place}.*" for place in places if isinstance(place, str)]
            yield from (name for name in names if name.partition(".")[0] in self._packages)

    def _absolute(self, node: ast.ImportFrom, path: Path) -> str:
        """The dotted name after ``from``, its leading dots resolved."""
        if not node.level:
            return node.module or ""
        package = path.relative_to(self.root).parent.parts
        parts = package[: len(package) - node.level + 1]
        return ".".join([*parts, *([node.module] if node.module else [])])

    def _named_by(self, path: Path) -> frozenset[Path]:
        """The files that one file names: imported modules and their packages, data, kernels."""
        if path not in self._named:
            part = self.parts[path]
            pieces = (name.split(".") for name in part.modules)
            dotted = {".".join(each[:end]) for each in pieces for end in range(1, len(each) + 1)}
            data = (file for name in part.files for file in self._data.get(name, ()))
            found = {self._modules[name] for name in dotted if name in self._modules}
            for name in part.modules:
                if name.endswith(".*"):
                    found |= {self._modules[each] for each in self._in_package(name[:-2])}
            self._named[path] = frozenset(found.union(data))
        return self._named[path]

    def _in_package(self, package: str) -> list[str]:
        """The names of a package's modules, without those of packages in it."""
        return [name for name in self._modules if name.rpartition(".")[0] == package]

    def _dotted(self, path: Path) -> str:
        parts = path.relative_to(self.root).with_suffix("").parts
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    def _module(self, name: str) -> Path:
        if name not in self._modules:
            raise InputError(f"there is no module {name}")
        return self._modules[name]


def _children(node: ast.AST) -> Iterator[tuple[str, Any]]:
    """The fields of a node without what tells people or type checkers something.

    Empty ones are left out, and empty pieces of formatted texts: versions of Python differ in them.
    """
    if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
        yield "orelse", node.orelse
        return
    for name, value in ast.iter_fields(node):
        if isinstance(value, list):
            value = [each for each in value if not _is_text_alone(each)]
        if isinstance(node, ast.JoinedStr):
            value = [each for each in value if getattr(each, "value", None) != ""]
        if name == "keywords" and _callee(node) in ARGPARSE:
            value = [each for each in value if each.arg not in HELP]
        if value is not None and value != []:
            yield name, value


def _is_text_alone(node: Any) -> bool:
    """Whether a statement is a docstring, or a text after a constant that explains it."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _callee(node: ast.AST) -> str:
    """The name of what a call calls, without its place."""
    function = getattr(node, "func", None)
    return str(getattr(function, "attr", getattr(function, "id", "")))


def _shape(value: Any) -> Any:
    """Code as nested tuples: equal where nothing but its looks differs."""
    if isinstance(value, ast.AST):
        fields = [(name, _shape(child)) for name, child in _children(value)]
        return (type(value).__name__, *fields)
    return [_shape(each) for each in value] if isinstance(value, list) else value


def _deciding(value: Any) -> Iterator[ast.AST]:
    """Every node that is part of the shape."""
    if isinstance(value, ast.AST):
        yield value
        for _, child in _children(value):
            yield from _deciding(child)
    elif isinstance(value, list):
        for each in value:
            yield from _deciding(each)


def _file_names(nodes: Iterable[ast.AST]) -> list[str]:
    """The text constants that may name a file, without their folders."""
    texts = {
        node.value.rsplit("/", 1)[-1]
        for node in nodes
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    return sorted(text for text in texts if re.fullmatch(r"[^\s.]\S*\.\w+", text))


def _sections(tree: ast.Module) -> Any:
    """The literal ``SECTIONS`` of a module, empty if it has none; None if it is no literal."""
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == "SECTIONS" for target in targets):
            try:
                value = ast.literal_eval(node.value)  # type: ignore[attr-defined]
                return json.loads(json.dumps(value))  # as it is when remembered
            except ValueError:
                return None
    return []


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()

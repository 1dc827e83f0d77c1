"""The house: five packages, arrows downwards only; within the library, rooms likewise."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

# Each imports from itself and from those after it.
PACKAGES = ("scripts", "paper", "reporting", "verification", "squeezefilm")
ROOMS = (
    *("cli", "api", "studies", "designs"),
    *("models", "reynolds", "film", "formulas", "io"),
)
NOT_IN_THE_LIBRARY = {"snakemake", "matplotlib", "mpl_toolkits", "plotly"}
WORKFLOW = Path(__file__).resolve().parents[2] / "workflow"


def imported(path: Path) -> Iterator[str]:
    """Dotted names that a module imports, inside functions too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: a relative import"
            yield from (f"{node.module}.{name.name}" for name in node.names)


def above(order: tuple[str, ...], name: str) -> set[str]:
    """Those that what is called ``name`` must not import."""
    return set(order[: order.index(name)])


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_import_downwards(package):
    files = sorted((WORKFLOW / package).rglob("*.py"))
    assert len(files) > 3
    for path in files:
        upwards = {name.split(".")[0] for name in imported(path)} & above(PACKAGES, package)
        assert not upwards, (path, upwards)


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_of_the_library_import_downwards(room):
    for path in sorted((WORKFLOW / "squeezefilm" / room).rglob("*.py")):
        ours = [name.split(".") for name in imported(path) if name.startswith("squeezefilm.")]
        upwards = {parts[1] for parts in ours} & above(ROOMS, room)
        assert not upwards, (path, upwards)


def commands() -> list[tuple[str, Path]]:
    """The dotted name and the file of every command."""
    found = []
    for path in sorted(WORKFLOW.rglob("*.py")):
        *package, name = path.relative_to(WORKFLOW).with_suffix("").parts
        if name != "__init__" and (
            package[-1] == "commands" or package[:2] == ["squeezefilm", "cli"]
        ):
            found.append((".".join((*package, name)), path))
    return [pair for pair in found if re.search(r"^def run\(", pair[1].read_text("utf-8"), re.M)]


def test_no_command_imports_another():
    """What two commands share is no command's: it has a room below them."""
    names = {name for name, _ in commands()}
    assert len(names) > 30
    for name, path in commands():
        others = {
            each
            for each in imported(path)
            for other in names - {name}
            if f"{each}.".startswith(f"{other}.")
        }
        assert not others, (name, others)


def test_every_room_has_its_place():
    found = {path.parent.name for path in (WORKFLOW / "squeezefilm").glob("*/__init__.py")}
    assert found == set(ROOMS)
    assert {path.parent.name for path in WORKFLOW.glob("*/__init__.py")} == set(PACKAGES)


def test_the_library_draws_nothing_and_knows_no_workflow():
    for path in sorted((WORKFLOW / "squeezefilm").rglob("*.py")):
        found = {name.split(".")[0] for name in imported(path)} & NOT_IN_THE_LIBRARY
        assert not found, (path, found)

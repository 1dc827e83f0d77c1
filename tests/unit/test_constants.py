"""The list of numeric constants is that of the code."""

import ast
import csv
from pathlib import Path

from squeezefilm.provenance import WORKFLOW_DIR

LIBRARY = WORKFLOW_DIR / "squeezefilm"


def is_number(value: ast.expr) -> bool:
    """Whether an expression is made of numbers alone, some of them decimal or large."""
    if isinstance(value, (ast.Tuple, ast.List)):
        return bool(value.elts) and all(map(is_number, value.elts))
    if isinstance(value, ast.UnaryOp):
        return is_number(value.operand)
    if isinstance(value, ast.BinOp):
        return is_number(value.left) and is_number(value.right)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def constants_of(path: Path) -> set[str]:
    """The constants of a module and its classes that are numbers, or tuples of numbers."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Assign):
            targets, value = node.targets, node.value
        elif isinstance(node, ast.AnnAssign) and node.value:
            targets, value = [node.target], node.value
        else:
            continue
        pairs = [(target, value) for target in targets]
        for target, number in pairs:
            if isinstance(target, ast.Tuple) and isinstance(number, ast.Tuple):
                pairs += zip(target.elts, number.elts, strict=True)
            elif isinstance(target, ast.Name) and target.id.isupper() and is_number(number):
                names.add(target.id)
    return names


def test_each_numeric_constant_of_the_solver_has_its_role(repository):
    text = (repository / "docs/data/constants.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    listed = {(row["module"], row["constant"]) for row in rows}
    found = {
        (path.relative_to(LIBRARY).as_posix(), name)
        for package in ("reynolds", "quantities")
        for path in (LIBRARY / package).rglob("*.py")
        for name in constants_of(path)
    }
    assert listed == found

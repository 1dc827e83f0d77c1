"""The notebook in docs/ runs as it stands, and its numbers are those that it shows."""

import ast
import contextlib
import io
import json
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import pandas as pd

from ..docs.commands import NUMBER, missing_lines

# The line about the device: points and iterations may differ between processors.
OF_THE_MACHINE = "GMRES iterations"


def shown(cell: dict[str, Any]) -> str:
    """What a cell's stored outputs say in text; pictures say nothing."""
    texts = [
        "".join(output.get("text", output.get("data", {}).get("text/plain", [])))
        for output in cell["outputs"]
        if output["output_type"] != "display_data"
    ]
    return "\n".join(texts)


def run(source: str, names: dict[str, Any]) -> str:
    """Run a cell as a notebook does; what it prints, and the value of its last line."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, "cell", "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
            if value is not None:
                print(repr(value))
    return printed.getvalue()


def lines_of(text: str) -> list[str]:
    lines = (" ".join(line.split()) for line in text.splitlines())
    return [line for line in lines if OF_THE_MACHINE not in line and NUMBER.search(line)]


def test_the_notebook_runs_and_shows_its_numbers(repository, monkeypatch):
    monkeypatch.chdir(repository / "docs")
    matplotlib.use("Agg")
    notebook = json.loads((repository / "docs/notebook.ipynb").read_text(encoding="utf-8"))
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names: dict[str, Any] = {}
    compared = 0
    with pd.option_context("display.width", 80, "display.float_format", None):
        for cell in cells:
            printed = lines_of(run("".join(cell["source"]), names))
            wanted = lines_of(shown(cell))
            assert missing_lines(wanted, printed) == [], "".join(cell["source"])
            compared += len(wanted)
            plt.close("all")  # the next picture is not drawn into this one
    assert compared > 20

"""Configuration of Sphinx (`make docs`), and the pages that are made from the code."""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
WORKFLOW = HERE.parent / "workflow"
sys.path.insert(0, str(WORKFLOW))

from squeezefilm import __version__
from squeezefilm.cli.main import commands_of
from squeezefilm.config.keys import key_table, schema

project, version, release = "squeezefilm", __version__, __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_theme = "furo"
exclude_patterns = ["_build", "**/_generated"]
autodoc_member_order = "bysource"
GENERATED = HERE / "reference" / "_generated"


def write_generated() -> None:
    """Write the keys of a study and the help of all commands as Markdown."""
    GENERATED.mkdir(exist_ok=True)
    (GENERATED / "keys.md").write_text(key_table(schema()), encoding="utf-8")
    helps = []
    for name in commands_of():
        words = [sys.executable, "-m", "squeezefilm", name, "--help"]
        text = subprocess.run(words, capture_output=True, text=True, check=True, cwd=WORKFLOW)
        helps.append(f"## {name}\n\n```text\n{text.stdout}```\n")
    (GENERATED / "commands.md").write_text("\n".join(helps), encoding="utf-8")


write_generated()

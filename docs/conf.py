"""Configuration of Sphinx (`make docs`), and the pages that are made from the code."""

import csv
import os
import re
import subprocess
import sys
from math import isfinite
from pathlib import Path

HERE = Path(__file__).resolve().parent
WORKFLOW = HERE.parent / "workflow"
sys.path.insert(0, str(WORKFLOW))
os.environ["PYTHONPATH"] = str(WORKFLOW)  # for the notebook's kernel

import pandas as pd
import yaml

from squeezefilm import __version__
from squeezefilm.cli.main import modules_by_command
from squeezefilm.columns import COLUMNS
from squeezefilm.config.keys import key_table, study_schema
from squeezefilm.film.gas import GASES_TABLE_PATH
from squeezefilm.film.validity import VALIDITY_LIMITS
from squeezefilm_workflow.paper.claims import verdict_text
from squeezefilm_workflow.reporting.pages import markdown_table

project, version, release = "squeezefilm", __version__, __version__
extensions = [
    *("myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"),
    "sphinx-mathjax-offline",  # formulas need no network
]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode, nb_execution_timeout, nb_execution_raise_on_error = "force", 600, True
nb_output_stderr = "remove"  # progress, such as that kernels are compiled
html_theme, html_title, html_show_copyright = "furo", f"squeezefilm {version}", False
html_static_path, html_css_files = ["_static"], ["site.css"]
exclude_patterns = ["_build", "**/_generated"]
autodoc_member_order, default_role = "bysource", "py:obj"
GENERATED = HERE / "reference" / "_generated"
HEAD_OF_LIMITS = (
    "| quantity | films | modelling error unverified above | equation invalid above | source |",
    "| --- | --- | --- | --- | --- |",
)


def bound(value: float) -> str:
    """Return a limit as the page shows it."""
    return f"{float(f'{value:.2g}'):g}" if isfinite(value) else "–"


def claims() -> list[str]:
    """Return the paper's claims beside the values of the checked reference, rows of a table."""
    with (HERE.parent / "tests/reference/paper/claims.csv").open(encoding="utf-8") as file:
        ours = {
            (row["item"], name): row[name]
            for row in csv.DictReader(file)
            for name in ("verdict", "ours")
            if row[name]
        }
    with (WORKFLOW / "squeezefilm_workflow/paper/papers_claims.csv").open(encoding="utf-8") as file:
        claims = list(csv.DictReader(file))
    rows = {kind: ["| claim | verdict | paper | ours | unit |"] for kind in ("result", "setting")}
    agreeing = dict.fromkeys(rows, 0)
    for each in claims:
        agrees = ours[each["claim_id"], "verdict"] == "agrees"
        verdict = verdict_text(agrees, within=each["within"], because=each["because"])
        value = ours.get((each["claim_id"], "ours"), "below 1 s")  # run times are not compared
        cells = each["claim"], verdict, each["paper"], value, each["unit"]
        rows[each["kind"]].append(f"| {' | '.join(cells)} |")
        agreeing[each["kind"]] += agrees
    lines: list[str] = []
    for kind, (head, *body) in rows.items():
        lines += [f"{agreeing[kind]} of {len(body)} {kind}s agree:", ""]
        lines += [head, "| --- | --- | --- | --- | --- |", *body, ""]
    return lines


def repository() -> str:
    """Return the address of the repository's pages, empty where none is known."""
    git = ["git", "-C", str(HERE), "remote", "get-url", "origin"]
    remote = subprocess.run(git, capture_output=True, text=True, check=False).stdout.strip()
    address = os.environ.get("SQUEEZEFILM_REPOSITORY") or remote.removesuffix(".git")
    address = re.sub(r"^(?:ssh://)?git@([^:/]+)[:/]", r"https://\1/", address)
    return address if address.startswith("https://") else ""


def citation() -> list[str]:
    """Return CITATION.cff as BibTeX, of the software and of the paper that it reproduces."""
    cff = yaml.safe_load((HERE.parent / "CITATION.cff").read_text(encoding="utf-8"))
    year = f"{cff['date-released']}"[:4]
    address = repository()
    fields = {
        "title": f"{{{cff['title']}: {cff['abstract']}}}",
        # In a second pair of braces: BibTeX takes them for one name.
        "author": f"{{{{{' and '.join(author['name'] for author in cff['authors'])}}}}}",
        "version": f"{{{cff['version']}}}",
        "year": f"{{{year}}}",
        **({"url": f"{{{address}}}"} if address else {}),
    }
    (paper,) = cff["references"]
    names = (f"{author['family-names']}, {author['given-names']}" for author in paper["authors"])
    fields_of_paper = {
        "title": f"{{{{{paper['title']}}}}}",
        "author": f"{{{' and '.join(names)}}}",
        "pages": f"{{{paper['start']}--{paper['end']}}}",
        **{name: f"{{{paper[name]}}}" for name in ("journal", "volume", "year", "doi")},
        "number": f"{{{paper['issue']}}}",
    }
    lines = bibtex("software{squeezefilm", fields) + bibtex("article{winter2014", fields_of_paper)
    links = ["", f"[Repository]({address}), [issues]({address}/issues)."] if address else []
    return ["```bibtex", *lines, "```", *links]


def bibtex(entry: str, fields: dict[str, str]) -> list[str]:
    """Return the lines of an entry."""
    return [f"@{entry},", *(f"  {name} = {value}," for name, value in fields.items()), "}"]


def stored(path: Path) -> tuple[list[str], list[str]]:
    """Return a stored table as the page shows it, one of each source, and the comments above it."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head, *body = csv.reader(line for line in lines if not line.startswith("# "))
    table = pd.DataFrame(body, columns=head)
    comments = [line[2:] for line in lines if line.startswith("# ")]
    if "source" not in table:
        return [markdown_table(table)], comments
    parts: list[str] = []
    for source, rows in table.groupby("source", sort=False):
        with_values = rows.columns[(rows != "–").any()].drop("source")
        parts += [f"**{source}**\n", markdown_table(rows[with_values])]
    return parts, comments


def measured(path: Path) -> str:
    """Return a stored table as the page shows it, and what made it if it was measured."""
    table, comments = stored(path)
    origin = dict(comment.split(": ", 1) for comment in comments)
    if "commit" not in origin:
        return "\n".join(table)
    known = (origin[name] for name in ("date", "machine") if name in origin)
    source = f"*Commit {origin['commit']}, {'; '.join(known)}.*"
    return "\n".join([*table, "", source])


def write_generated() -> None:
    """Write keys, columns, help of all commands, limits of validity, claims, measured tables."""
    GENERATED.mkdir(exist_ok=True)
    rows = [
        f"| {limit.quantity} {limit.symbol} | {limit.film_kind} | {bound(limit.unverified_above)} "
        f"| {bound(limit.not_applicable_above)} | {limit.source} |"
        for limit in VALIDITY_LIMITS
    ]
    (GENERATED / "limits.md").write_text("\n".join([*HEAD_OF_LIMITS, *rows]), encoding="utf-8")
    names = (f"| `{name}` | {' | '.join(column[1:4])} |" for name, column in COLUMNS.items())
    head = "| column | unit | meaning | tables |", "| --- | --- | --- | --- |"
    (GENERATED / "columns.md").write_text("\n".join([*head, *names]), encoding="utf-8")
    pages = re.compile(r"docs/([\w/-]+\.md)")
    keys = pages.sub(r"[](/\1)", key_table(study_schema()))
    (GENERATED / "keys.md").write_text(keys, encoding="utf-8")
    table, sources = stored(GASES_TABLE_PATH)
    (GENERATED / "gases.md").write_text("\n".join([*table, "", *sources]), encoding="utf-8")
    (GENERATED / "citation.md").write_text("\n".join(citation()), encoding="utf-8")
    (GENERATED / "claims.md").write_text("\n".join(claims()), encoding="utf-8")
    for path in sorted((HERE / "data").glob("*.csv")):
        (GENERATED / f"{path.stem}.md").write_text(measured(path), encoding="utf-8")
    helps = []
    for name in modules_by_command():
        words = [sys.executable, "-m", "squeezefilm", name, "--help"]
        text = subprocess.run(words, capture_output=True, text=True, check=True, cwd=WORKFLOW)
        helps.append(f"## {name}\n\n```text\n{text.stdout}```\n")
    (GENERATED / "commands.md").write_text("\n".join(helps), encoding="utf-8")


if address := repository():
    html_theme_options = {
        "source_repository": f"{address}/",
        "source_branch": "main",
        "source_directory": "docs/",
    }
write_generated()

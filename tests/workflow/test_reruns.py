"""An edit makes anew what depends on it and nothing else; what is deleted comes back."""

import ast
import re
import shutil
from pathlib import Path

import pytest

from squeezefilm.provenance import CODE_PATHS_OF_STAGE, WORKFLOW_DIR

from .conftest import EVERYTHING, QUICK, copy_checkout, made_anew, snakemake

NOTHING = "Nothing to be done"
CONFIG = Path("config/quick.yaml")
OF_A_DESIGN = {"two_factor_design", "four_factor", "four_factor_design"}
OF_THE_STUDY = {"screen", "error_map", "sweep", "validation_two_factor", "validation_four_factor"}


def simulated(made: set[str]) -> set[str]:
    """The plans of which the forces are among some files."""
    return {Path(name).parts[3] for name in made if Path(name).stem == "forces"}


@pytest.mark.parametrize(
    ("before", "after", "anew", "plans", "kept"),
    [
        ("seeds: {two_factor: 1", "seeds: {two_factor: 2", "fits/screen.json", OF_A_DESIGN, None),
        ("  points: 30\n", "  points: 31\n", "simulations/sweep/scenes.parquet", {"sweep"}, "fits"),
        ("tolerance: 1e-4", "tolerance: 2e-4", "fits/screen.json", OF_THE_STUDY, None),
    ],
    ids=["fit.seeds", "sweep.points", "solver.tolerance"],
)
def test_a_section_makes_anew_what_depends_on_it(before, after, anew, plans, kept, finished):
    text = (finished.folder / CONFIG).read_text(encoding="utf-8")
    assert before in text
    made = made_anew(finished.folder, *EVERYTHING, edits={CONFIG: text.replace(before, after)})
    assert f"results/quick/{anew}" in made
    assert plans <= simulated(made)
    if plans != OF_THE_STUDY:
        assert simulated(made).isdisjoint(OF_THE_STUDY - plans)
    assert not [name for name in made if kept and name.startswith(f"results/quick/{kept}/")]


@pytest.mark.parametrize(
    ("file", "anew", "plans"),
    [
        ("squeezefilm/reynolds/periodic/periodic.cl", "figures/fig08.png", OF_THE_STUDY),
        ("squeezefilm_workflow/reporting/figures/style.py", "figures/fig08.png", set()),
    ],
)
def test_an_edit_of_the_code_makes_its_stage_anew_and_what_follows(file, anew, plans, finished):
    path = Path("workflow") / file
    text = (finished.folder / path).read_text(encoding="utf-8")
    comment = "/* edited */" if path.suffix == ".cl" else "# edited"
    made = made_anew(finished.folder, *EVERYTHING, edits={path: f"{text}{comment}\n"})
    assert f"results/quick/{anew}" in made
    assert simulated(made) & OF_THE_STUDY == plans
    assert not [name for name in made if "fits/" in name and "/reporting/" in file]


def imported(path: Path) -> set[Path]:
    """The library's modules that one imports, inside functions too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{name.name}" for name in node.names} | {node.module}
    files = {WORKFLOW_DIR / f"{name.replace('.', '/')}.py" for name in names}
    return {file for file in files if file.is_file()}


def scripts_of(stage: str) -> list[Path]:
    """The scripts of the rules of a stage; a rule's digest is of its script too."""
    rules = "".join(path.read_text("utf-8") for path in (WORKFLOW_DIR / "rules").glob("*.smk"))
    scripts = re.findall(rf'code_of\("{stage}", "(\w+)"\)', rules)
    # Of simulate.py the extrapolation's plan alone reads fits; it has the models' digest.
    return [WORKFLOW_DIR / f"scripts/{name}.py" for name in scripts if name != "simulate"]


@pytest.mark.parametrize("stage", ["solver", "models"])
def test_the_digest_of_a_stage_covers_all_that_its_scripts_import(stage):
    covered = {
        file
        for source in CODE_PATHS_OF_STAGE[stage]
        for file in (WORKFLOW_DIR / source).rglob("*.py")
    }
    covered |= {
        WORKFLOW_DIR / source for source in CODE_PATHS_OF_STAGE[stage] if source.endswith(".py")
    }
    waiting = scripts_of(stage)
    assert waiting
    reached = set()
    while waiting:
        reached.add(file := waiting.pop())
        waiting += imported(file) - reached
    beyond = {str(file.relative_to(WORKFLOW_DIR)) for file in reached - covered}
    # What begins a script, writes what made the results and names the version decides no result.
    beyond -= {"squeezefilm/provenance.py", "squeezefilm/__init__.py"}
    beginnings = ("scripts/", "squeezefilm_workflow/job.py", "squeezefilm_workflow/finished.py")
    assert not {name for name in beyond if not name.startswith(beginnings)}


def test_edits_that_are_undone_and_new_times_make_nothing_anew(finished):
    for path in [*(finished.folder / "workflow").rglob("*.py"), finished.folder / CONFIG]:
        path.write_bytes(path.read_bytes())  # the same text, a new time
    assert made_anew(finished.folder, *EVERYTHING) == set()


def test_results_copied_to_a_clone_are_up_to_date(finished, tmp_path):
    """Without Snakemake's records there are the files' times alone."""
    clone = copy_checkout(finished.folder, tmp_path / "clone")
    shutil.copytree(finished.folder / "results", clone / "results")  # with their times
    assert NOTHING in snakemake(clone, *EVERYTHING, "--dry-run", *QUICK).stdout


def test_a_deleted_file_comes_back(finished, tmp_path):
    folder = copy_checkout(finished.folder, tmp_path / "deleted", "results", ".snakemake")
    file = folder / "results/quick/tables/table1.csv"
    text = file.read_text(encoding="utf-8")
    file.unlink()
    done = snakemake(folder, *EVERYTHING, *QUICK)
    assert done.returncode == 0, done.stdout
    assert "The paper's tables and claims" in done.stdout
    assert not re.search("Simulate|Fit the|D-optimal", done.stdout)  # a copy is as good as the run
    assert file.read_text(encoding="utf-8") == text
    # The page that was made is named.
    assert re.search(r"^Open results/quick/report/\w+\.html$", done.stdout, re.MULTILINE)


def test_a_run_without_a_page_names_the_table_of_its_forces(finished, tmp_path):
    folder = copy_checkout(finished.folder, tmp_path / "sweep", "results", ".snakemake")
    forces = Path("results/quick/simulations/sweep/forces.parquet")
    (folder / forces).unlink()
    done = snakemake(folder, "sweep", *QUICK)
    assert done.returncode == 0, done.stdout
    assert (folder / forces).exists()
    assert f"\nForces: {forces}\n" in done.stdout

"""The packages as they are installed: the wheel, outside the checkout, without extras."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

# What the extras bring: the library must do without.
EXTRAS = ("matplotlib", "markdown_it", "plotly", "pyarrow", "pygments", "pymoo", "skfem", "xarray")
PACKAGES = ("squeezefilm", "squeezefilm_workflow")
SUFFIXES = {".py", ".pyi", ".typed", ".cl", ".csv", ".in", ".yaml"}
ALONE = f"""
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {(*EXTRAS, "snakemake")}:
            raise ImportError(f"{{name}} is not installed here")
sys.meta_path.insert(0, Absent())
sys.path = [sys.argv[1], *(place for place in sys.path if not place.endswith("/workflow"))]
import squeezefilm as sf
assert sf.__file__.startswith(sys.argv[1]), sf.__file__
"""


def printed(site: Path, code: str) -> str:
    """Run code after importing the library from the wheel, isolated, outside the checkout."""
    done = subprocess.run(
        [sys.executable, "-I", "-c", ALONE + code, str(site)],
        cwd=site,
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_is_what_the_rules_import_with_all_its_data_and_nothing_else(
    installed, repository
):
    found, wanted = (
        {
            path.relative_to(folder)
            for package in PACKAGES
            for path in (folder / package).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        for folder in (installed, repository / "workflow")
    )
    assert found == wanted
    assert {path.suffix for path in found if path.parts[0] == "squeezefilm"} == SUFFIXES
    folders = {path.name for path in installed.iterdir() if path.suffix != ".dist-info"}
    assert folders == set(PACKAGES)


def test_a_force_needs_no_checkout_and_no_workflow(installed):
    code = (
        "film = sf.Film.of(actuator={'frequency': 43270, 'surface_radius': 0.01,\n"
        "    'profile': {'kind': 'sinc', 'wave_number': 109.8}},\n"
        "    pad={'length_x': 0.01, 'length_y': 0.01},\n"
        "    gas={'inertia': 'none', 'thermal': 'none'})\n"
        "print(float(film.force('5 um', '2.2 um', tolerance=1e-4)))"
    )
    assert float(printed(installed, code)) == pytest.approx(0.962042, rel=1e-4)


def test_a_search_for_parameters_needs_no_extra(installed):
    code = (
        "import numpy as np\n"
        "from squeezefilm.models.search import genetic_search\n"
        "ends = {'lower': np.zeros(1), 'upper': np.ones(1)}\n"
        "print(genetic_search(lambda x: (x[:, 0] - 0.3) ** 2, **ends, seed=1).x[0])\n"
    )
    assert float(printed(installed, code)) == pytest.approx(0.3, abs=1e-3)


def test_what_needs_an_extra_names_it(installed):
    code = (
        "film = sf.Film.of(actuator={'frequency': 43270, 'surface_radius': 0.01,\n"
        "    'profile': {'kind': 'piston'}}, pad={'length_x': 0.01, 'length_y': 0.01})\n"
        "try:\n    film.pressure(5e-6, 1e-6)\n"
        "except sf.InputError as error:\n    print(error)\n"
        "from squeezefilm.tables import read_scenes\n"
        "try:\n    read_scenes('some.parquet')\n"
        "except sf.InputError as error:\n    print(error)\n"
    )
    told = printed(installed, code).splitlines()
    assert [
        f"squeezefilm[{extra}]" in line
        for extra, line in zip(("fields", "parquet"), told, strict=True)
    ] == [True] * 2, told

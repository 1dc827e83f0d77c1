"""The example of each function on the page of Python runs as it stands."""

import doctest
import inspect
import shutil

import pandas as pd
import pytest

import squeezefilm as sf

ORDER = ("load", "fit", "save")
"""Functions whose examples make what other examples use."""


def functions():
    """Return the public functions and properties of the library, by name."""
    found = {"load": sf.load}
    for owner in (sf.Film, sf.Study, sf.Fit):
        for name, member in vars(owner).items():
            member = getattr(member, "fget", None) or getattr(member, "__func__", member)
            if not name.startswith("_") and inspect.isfunction(member):
                found[name] = member
    return found


@pytest.fixture
def folder(repository, tmp_path, monkeypatch):
    (tmp_path / "config").mkdir()
    shutil.copy(repository / "config/quick.yaml", tmp_path / "config/paper.yaml")
    shutil.copy(repository / "config/levitation.yaml", tmp_path / "config/levitation.yaml")
    monkeypatch.chdir(tmp_path)


def test_every_function_has_an_example_that_runs(folder):
    found = functions()
    examples = {
        name: doctest.DocTestParser().get_examples(inspect.getdoc(function) or "")
        for name, function in found.items()
    }
    assert [name for name in found if not examples[name]] == ["name", "about"]
    names = {"sf": sf, "pd": pd, "Film": sf.Film, "Fit": sf.Fit}
    first = {name: examples.pop(name) for name in ORDER}
    for lines in (first | examples).values():
        for line in lines:
            exec(compile(line.source, "example", "single"), names)
    assert names["force"].force_n > names["force"].error_n > 0
    assert names["film"].force(h0="8 um", hv="3 um", tolerance=1e-2).force_n > 0

"""A study is checked once, and again as soon as anything that its checks rest on is another one."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from squeezefilm.film.vibration.scans import smoothed_scan
from squeezefilm.io.errors import InputError
from squeezefilm.runs import checked
from squeezefilm.runs.basis import basis_file, forget_others
from squeezefilm.runs.checked import CheckedStudy, checked_study
from squeezefilm.runs.code import Code
from squeezefilm.studies.config import load_config

CODE = Code()


@pytest.fixture
def study(repository, tmp_path):
    """A study with a measured profile."""
    for name in ("vibrometer.yaml", "vibrometer.csv"):
        (tmp_path / name).write_bytes((repository / "config" / name).read_bytes())
    return tmp_path / "vibrometer.yaml"


@pytest.fixture
def checks(monkeypatch):
    """The studies that were really checked."""
    check, done = checked._check, []

    def counted(path: Path) -> CheckedStudy:
        done.append(path)
        return check(path)

    monkeypatch.setattr(checked, "_check", counted)
    return done


def test_a_study_is_checked_again_when_it_or_its_scan_is_another(study, checks, tmp_path):
    def ask() -> CheckedStudy:
        smoothed_scan.cache_clear()  # every run is a process of its own
        return checked_study(study, code=CODE, memory=tmp_path / "memory")

    first = ask()
    assert ask() == first
    assert len(checks) == 1
    assert dict(first.config) == dict(load_config(study))
    assert first.scan == study.with_name("vibrometer.csv")
    assert first.chunks["screen"] >= 1
    scan = first.scan.read_text()
    first.scan.write_text(scan.replace("0.0828", "0.0829"))
    ask()
    assert len(checks) == 2
    first.scan.write_text("nonsense\n")
    for _ in range(2):  # what is refused is not kept
        with pytest.raises(InputError, match=r"vibrometer\.csv"):
            ask()
    first.scan.unlink()
    with pytest.raises(InputError, match="there is no such scan"):
        ask()
    first.scan.write_text(scan)
    study.write_text(study.read_text().replace("length_x", "length_z"))
    for _ in range(2):
        with pytest.raises(InputError, match="length_z"):
            ask()


READ = """
import sys
from pathlib import Path
from squeezefilm.runs import basis, locks, run_card
from squeezefilm.runs.checked import checked_study
from squeezefilm.runs.code import Code
from squeezefilm.studies import given
memory = Path(sys.argv[2])
checked_study(Path(sys.argv[1]), code=Code(memory=memory / "code.json"), memory=memory)
print(*sys.modules)
"""


def test_a_study_that_was_checked_is_read_without_what_checks_it(repository, study, tmp_path):
    """A run with nothing to do reads it, with all else that the rules import."""
    memory = tmp_path / "memory"
    checked_study(study, code=Code(memory=memory / "code.json"), memory=memory)
    words = [sys.executable, "-c", READ, str(study), str(memory)]
    done = subprocess.run(
        words, cwd=repository / "workflow", capture_output=True, text=True, check=True
    )
    loaded = {name.partition(".")[0] for name in done.stdout.split()}
    assert {"yaml", "squeezefilm"} <= loaded
    assert loaded.isdisjoint({"numpy", "pandas", "scipy", "pyopencl", "jsonschema"})


def test_a_damaged_memory_does_no_harm(study, checks, tmp_path):
    first = checked_study(study, code=CODE, memory=tmp_path / "memory")
    (kept,) = (tmp_path / "memory").iterdir()
    kept.write_text(kept.read_text()[:100])
    assert checked_study(study, code=CODE, memory=tmp_path / "memory") == first
    assert len(checks) == 2


def test_a_basis_is_named_by_what_it_lists(tmp_path):
    def basis(**sections: Any) -> Path:
        files = CODE.of("gather")
        return basis_file(tmp_path, "gather", code=CODE, files=files, sections=sections)

    first = basis(gas={"a": 1, "b": 2})
    time = first.stat().st_mtime_ns
    assert basis(gas={"b": 2, "a": 1}) == first
    assert first.stat().st_mtime_ns == time
    other = basis(gas={"a": 1, "b": 3})
    longer = tmp_path / f"gather-{'x' * len(first.stem)}.txt"
    longer.touch()  # of a command whose name begins alike
    forget_others(other)
    assert {*tmp_path.iterdir()} == {other, longer}

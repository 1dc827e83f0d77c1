"""Compiled kernels that a full disk or a broken copy has damaged are built anew, or named."""

import os
import shutil
import subprocess
import sys

import pytest

from squeezefilm.reynolds import self_test
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.kernel_cache import kernel_cache_folder

if "Portable Computing Language" not in choose_device().name:
    pytest.skip("of PoCL's cache", allow_module_level=True)

SQUARE = """
import numpy as np
from squeezefilm.lazy import cl
from squeezefilm.reynolds.device import choose_device, compiled_kernel, run_kernel
device = choose_device()
source = "kernel void square(global double *a) { a[0] *= a[0]; }"
square = compiled_kernel(device, "square", sources=(), header=source)
values = np.array([3.0])
buffer = device.copy_to_buffer(values)
run_kernel(device, square, buffer, groups=1)
cl.enqueue_copy(device.queue, values, buffer)
print(values[0])
"""


def squared(folder, **variables):
    done = subprocess.run(
        [sys.executable, "-c", SQUARE],
        env={**os.environ, "POCL_CACHE_DIR": str(folder), **variables},
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pocl")
    assert squared(folder)[:2] == (0, "9.0\n")
    return folder


def cut(content):
    return content[: len(content) // 2]


def zeroed(content):
    return bytes(len(content))


@pytest.mark.parametrize(
    ("pattern", "damaged"),
    [("*.so", cut), ("*.so", zeroed), ("program.bc", cut)],
)
def test_a_damaged_program_is_built_anew(pattern, damaged, filled, tmp_path):
    folder = shutil.copytree(filled, tmp_path / "pocl")
    (path,) = folder.rglob(pattern)
    sound = path.stat().st_size
    path.write_bytes(damaged(path.read_bytes()))
    assert squared(folder)[:2] == (0, "9.0\n")
    (path,) = folder.rglob(pattern)
    assert path.stat().st_size == pytest.approx(sound, rel=0.01)


def test_a_sound_program_stays(filled):
    (path,) = filled.rglob("*.so")
    before = path.stat().st_mtime_ns
    assert squared(filled)[:2] == (0, "9.0\n")
    assert path.stat().st_mtime_ns == before


def test_a_program_that_is_known_needs_no_linker(filled, tmp_path):
    assert squared(filled, PATH=str(tmp_path))[:2] == (0, "9.0\n")


def test_a_program_that_is_known_is_not_looked_for_among_all_others(filled, tmp_path):
    """A look at each of 1 900 programs took a tenth of a command for one force."""
    folder = shutil.copytree(filled, tmp_path / "pocl")
    other = folder / "AA" / "OTHER"
    other.mkdir(parents=True)
    for name in ("last_accessed", "program.bc"):
        (other / name).write_bytes(b"of another process that writes it")
    assert squared(folder)[:2] == (0, "9.0\n")
    assert (other / "program.bc").exists()


def test_doctor_outlives_a_kernel_that_ends_its_process(monkeypatch, refused):
    monkeypatch.setattr(self_test, "FORCE_SCRIPT", "import os; os.abort()")
    told = refused("doctor", status=1)
    assert (
        f"ended by SIGABRT. A compiled kernel may be damaged: remove {kernel_cache_folder()}"
        in told
    )


def test_doctor_asks_for_a_force_as_a_user_does(monkeypatch, refused):
    """Stored films alone passed on a driver on which no second process had a force."""
    one = self_test.FORCE_SCRIPT.replace('solution.status == "ok"', "False")
    monkeypatch.setattr(self_test, "FORCE_SCRIPT", one)
    assert "the self-test gives no force: ok" in refused("doctor", status=1)

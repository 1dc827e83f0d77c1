"""Oclgrind runs every kernel item by item: no races, no barrier that only some reach, right forces.

It compiles in a second what PoCL, whose work-groups are loops, takes minutes for.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from squeezefilm.reynolds.device import choose_device

from .simulated import FAULTS, KERNELS, means

pytestmark = pytest.mark.skipif(
    shutil.which("oclgrind") is None, reason="Oclgrind is not installed (Debian: oclgrind)"
)
WATCH = ("--data-races", "--uniform-writes", "--uninitialized", "--max-errors", "3")
SCRIPT = Path(__file__).with_name("simulated.py")


def watched(*words: str) -> subprocess.Popen[str]:
    """A process of its own for each kernel: one that comes after another is not watched well."""
    command = ["oclgrind", *WATCH, sys.executable, str(SCRIPT), "oclgrind", *words]
    plain = os.environ | {"PYOPENCL_BUILD_OPTIONS": "-cl-opt-disable"}  # as it knows few passes
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=plain)


@pytest.mark.parametrize(
    ("kernel", "items"), [*((kernel, 8) for kernel in KERNELS), ("inertia", 64)]
)
def test_work_items_keep_out_of_each_other_s_way(kernel: str, items: int) -> None:
    with watched(str(items), kernel) as process:
        found, errors = process.communicate(timeout=900)
    # A loaded machine takes long enough to compile for this to be announced.
    told = [line for line in errors.splitlines() if line and "compiling kernels" not in line]
    assert (process.returncode, told) == (0, [])
    alone = means(choose_device(), kernel)
    assert json.loads(found) == pytest.approx(alone, rel=1e-9)


@pytest.mark.parametrize(
    ("fault", "message"),
    [*zip(FAULTS, ("data race at global memory", "divergence detected (barrier)"), strict=True)],
)
def test_a_fault_is_found(fault: str, message: str) -> None:
    """Sixteen items: of eight each would read from this grid's field what it wrote itself."""
    with watched("16", "squeeze", fault) as process:
        assert process.stderr
        found = any(message in line for line in process.stderr)
        process.kill()  # a state that is wrong is looked for in vain, at length
    assert found

"""The table of registers in docs/solver.md comes from a command that runs."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PTXAS = shutil.which("ptxas")
LIBRARY = Path("/usr/lib/clc/nvptx64--nvidiacl.bc")


@pytest.mark.skipif(
    PTXAS is None or shutil.which("clang-14") is None or not LIBRARY.exists(),
    reason="needs clang-14 and libclc-14 (Debian) and ptxas (PyPI: nvidia-cuda-nvcc-cu12)",
)
def test_a_kernel_becomes_code_for_graphics_processors() -> None:
    script = Path(__file__).with_name("registers.py")
    command = [sys.executable, str(script), PTXAS, "squeeze"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    *_, row = done.stdout.splitlines()
    kernel, *numbers = (cell.strip() for cell in row.strip("|").split("|"))
    assert kernel == "squeeze"
    assert 32 <= int(numbers[0]) <= 255
    assert all(number.isdecimal() for number in numbers)

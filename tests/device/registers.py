"""What compilers for graphics processors make of the kernels: registers and spills, as a table.

python tests/device/registers.py PTXAS [KERNEL ...] > TABLE.md

Needs no such processor. Debian's clang-14 and libclc-14 turn OpenCL C into PTX and AMD code, and
NVIDIA's assembler, PTXAS, comes with `pip install nvidia-cuda-nvcc-cu12`.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import squeezefilm.reynolds
from squeezefilm.io.markdown import markdown_rows
from squeezefilm.reynolds import device

sys.path.insert(0, str(Path(__file__).parent))
from simulated import KERNELS, means

ITEMS = 128
NVIDIA, AMD = "sm_90", "gfx90a"
CLANG = (
    *("clang-14", "-x", "cl", "-cl-std=CL1.2", "-O3", "-cl-mad-enable", "-nogpulib", "-S", "-w"),
    *("-Xclang", "-finclude-default-header", "-Xclang", "-mlink-builtin-bitcode", "-Xclang"),
)
LIBRARIES = Path("/usr/lib/clc")
# PTX for the newest processor that clang 14 knows; PTXAS takes it on to newer ones.
FOR_NVIDIA = ("-target", "nvptx64-nvidia-nvcl", "-Xclang", "-target-cpu", "-Xclang", "sm_80")
FOR_AMD = ("-target", "amdgcn-amd-amdhsa", f"-mcpu={AMD}")
SAME = {"off the centre": "squeeze"}  # one program


def program(kernel: str) -> tuple[str, tuple[str, ...]]:
    """The text that a driver is given for a kernel, and what it defines."""
    found = []

    def recorded(context, header, sources, defines):
        folder = Path(squeezefilm.reynolds.__file__).parent
        texts = [header, *((folder / name).read_text(encoding="utf-8") for name in sources)]
        options = [f"-D{each}" for each in defines if not each.startswith("WORK_ITEMS")]
        found.append(("\n".join(texts), (f"-DWORK_ITEMS={ITEMS}", *options)))
        return build(context, header, sources, defines)

    build, device._program = device._program, recorded
    device._kernel.cache_clear()
    try:
        means(device.choose_device(), kernel)
    finally:
        device._program = build
    return found[0]


def numbers(kernel: str, ptxas: str, folder: Path) -> list[str]:
    """A row of the table."""
    text, defines = program(kernel)
    source = folder / "kernel.cl"
    source.write_text(text, encoding="utf-8")

    def compiled(target: tuple[str, ...], library: str) -> Path:
        output = folder / "kernel.s"
        command = [*CLANG, str(LIBRARIES / library), *target, *defines, source, "-o", output]
        subprocess.run(command, check=True)
        return output

    ptx = compiled(FOR_NVIDIA, "nvptx64--nvidiacl.bc")
    said = subprocess.run(
        [ptxas, f"-arch={NVIDIA}", "-v", ptx, "-o", "/dev/null"],
        check=True,
        capture_output=True,
        text=True,
    ).stderr
    patterns = (r"Used (\d+) registers", r"(\d+) bytes spill stores", r"(\d+) bytes spill loads")
    nvidia = [re.findall(pattern, said)[-1] for pattern in patterns]
    code = compiled(FOR_AMD, "amdgcn--amdhsa.bc").read_text(encoding="utf-8")
    amd = [
        re.findall(rf"\.{name}:\s*(\d+)", code)[-1] for name in ("vgpr_count", "vgpr_spill_count")
    ]
    return [kernel, *nvidia, *amd]


def main(ptxas: str, *kernels: str) -> None:
    header = ["kernel", f"registers, {NVIDIA}", "bytes spilled", "bytes loaded again"]
    header += [f"registers, {AMD}", "of them spilled"]
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            numbers(kernel, ptxas, Path(folder))
            for kernel in kernels or KERNELS
            if kernel not in SAME
        ]
    print(markdown_rows([header, *rows]), end="")


if __name__ == "__main__":
    main(*sys.argv[1:])

"""The OpenCL device that solves, and the programs built for it."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import struct
import threading
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.lazy import cl
from squeezefilm.parallel import print_step
from squeezefilm.reynolds.kernel_cache import (
    check_kernel_cache,
    is_cached_program_intact,
    record_cached_program,
    remove_damaged_programs,
)

DEVICE_ENV_VARIABLE = "SQUEEZEFILM_DEVICE"
ALIGNMENT_BYTES = 64
# Doubles behind an array that kernels may read with the last of it, and not use (vectors.cl).
PADDING_DOUBLES = 8
# Host arrays that a pool keeps: how many, and doubles of each.
MAX_POOLED_ARRAYS, MIN_POOLED_DOUBLES, MAX_POOLED_DOUBLES = 4, 2**17, 2**22
BUILD_OPTIONS = ("-cl-std=CL1.2", "-cl-mad-enable")
# Vectors of 64 bytes need all of these, and a compiler that uses them. PoCL's LLVM is older than
# some processors and takes them for earlier ones without AVX-512: it would emulate such vectors by
# halves, slowly and with a warning for each. Kernels are therefore compiled for these sets by name.
FLAGS_FOR_64_BYTE_VECTORS = (
    "avx512f",
    "avx512dq",
    "avx512vl",
    "avx512bw",
    "avx512cd",
    "fma",
    "avx2",
)
# LLVM calls a processor that is younger than itself ``generic``; PoCL 3.0 hands that name to the
# compiler, which refuses it (pocl issue 1049), and has no setting for another. The name lies behind
# a pointer in PoCL's record of the device: there it is replaced by the instruction set that the
# processor has, in the levels of the x86-64 ABI. Here is what each level adds to the one before.
FLAGS_OF_INSTRUCTION_SET = {
    "x86-64-v2": {"cx16", "lahf_lm", "popcnt", "sse4_1", "sse4_2", "ssse3"},
    "x86-64-v3": {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"},
    "x86-64-v4": {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"},
}
GENERIC_PROCESSOR = "generic"
CPU_INFO_FILE = Path("/proc/cpuinfo")
# The record's first bytes, among which the pointer is looked for.
POCL_DEVICE_RECORD_BYTES = 1024


@dataclass(frozen=True)
class Device:
    """An OpenCL device with a queue, and how the solver spreads over it.

    Attributes:
        context, queue: pyopencl objects; the queue runs kernels one after the other.
        transfer_queue: a queue for what comes back, which need not wait for kernels behind its own.
        name: platform and device name, as reported by ``doctor`` and kept with results.
        work_group_count_max: work-groups to launch, each with its workspace.
        work_items_per_group: work-items per group; 1 on a processor, whose groups are cores.
        vector_register_bytes: size of the vectors that a processor computes with.
        instruction_sets: those that kernels are compiled for, beyond what the driver knows.
        memory_bytes: the device's own memory.
        is_cpu: whether it is one, and not an accelerator.
        process_id: of the process that may use it: a forked one waits for ever for its threads.
        workspace_buffers: the buffer that kernels work in, kept from launch to launch.
        pooled_arrays: host arrays that launches are done with, for the next ones.
    """

    context: Any
    queue: Any
    transfer_queue: Any
    name: str
    work_group_count_max: int
    work_items_per_group: int
    memory_bytes: int
    is_cpu: bool = True
    vector_register_bytes: int = 32
    instruction_sets: tuple[str, ...] = ()
    process_id: int = field(default_factory=os.getpid)
    workspace_buffers: list[Any] = field(default_factory=list, compare=False)
    pooled_arrays: list[np.ndarray] = field(default_factory=list, compare=False)

    def check_process(self) -> None:
        """Raise InputError in a process that was forked after the device was chosen."""
        if os.getpid() != self.process_id:
            raise InputError(
                f"the OpenCL device belongs to process {self.process_id}, from which this one was "
                "forked after a force; start processes first, or by multiprocessing's 'spawn'"
            )

    def work_group_count(self, scenes: int, *, workspace_bytes: int) -> int:
        """Return the work-groups to launch: at most one a scene, and within half the memory."""
        room = self.memory_bytes // 2 // workspace_bytes
        return max(1, min(self.work_group_count_max, scenes, room))

    def vector_width(self, number_bytes: int) -> int:
        """Return the number of values that a work-item computes with at a time."""
        return 4 if self.work_items_per_group > 1 else self.vector_register_bytes // number_bytes

    def copy_to_buffer(self, values: np.ndarray) -> Any:
        """A buffer that holds a copy of ``values``."""
        flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.context, flags, hostbuf=values)

    def shared_buffer(self, values: np.ndarray) -> Any:
        """A buffer that starts as ``values``; ``fetch_buffer`` brings back what kernels make of it.

        A device that works in the host's memory, like a processor, gets the array itself, which
        must then come from ``aligned_array`` if kernels read it in vectors.
        """
        kind = cl.mem_flags.USE_HOST_PTR if self._uses_host_memory else cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.context, cl.mem_flags.READ_WRITE | kind, hostbuf=values)

    def fetch_buffer(self, values: np.ndarray, buffer: Any, *, after: Any) -> None:
        """Wait for the event of a kernel and bring a shared buffer's contents into its array."""
        if not self._uses_host_memory:
            cl.enqueue_copy(self.transfer_queue, values, buffer, wait_for=[after])
            return
        where = (0, values.shape, values.dtype)
        mapped, _ = cl.enqueue_map_buffer(
            self.transfer_queue, buffer, cl.map_flags.READ, *where, wait_for=[after]
        )
        mapped.base.release(self.transfer_queue)

    @property
    def loops_over_work_items(self) -> bool:
        """Return whether kernels are compiled with a loop over the work-items between barriers."""
        return (
            self.work_items_per_group > 1
            and self.is_cpu
            and _is_pocl_device(self.context.devices[0])
        )

    def workspace_buffer(self, numbers: int) -> Any:
        """A buffer of so many doubles, or more, for a kernel to work in, and padding.

        All kernels get the same one, for the queue runs them one after the other, and it is kept:
        new memory is expensive, the system clears its pages first.
        """
        size = 8 * (numbers + PADDING_DOUBLES)
        if not self.workspace_buffers or self.workspace_buffers[0].size < size:
            self.workspace_buffers.clear()
            self.workspace_buffers.append(cl.Buffer(self.context, cl.mem_flags.READ_WRITE, size))
        return self.workspace_buffers[0]

    def host_array(self, count: int) -> np.ndarray:
        """An array of so many doubles, or more, as whoever had it before has left it.

        The system clears the pages of new memory, which takes a tenth of the time of a batch.
        """
        if count > MAX_POOLED_DOUBLES:
            return aligned_array(count)
        array = (
            self.pooled_arrays.pop() if self.pooled_arrays else aligned_array(MIN_POOLED_DOUBLES)
        )
        return array if array.size >= count else aligned_array(count)

    def recycle_arrays(self, *arrays: np.ndarray) -> None:
        """Let the next launches have some host arrays."""
        small = [array for array in arrays if array.size <= MAX_POOLED_DOUBLES]
        self.pooled_arrays.extend(small[: MAX_POOLED_ARRAYS - len(self.pooled_arrays)])

    @cached_property
    def _uses_host_memory(self) -> bool:
        return bool(self.context.devices[0].host_unified_memory)


def aligned_array(count: int) -> np.ndarray:
    """Room for doubles that kernels can read as vectors, shape (count,)."""
    room = np.empty(count + ALIGNMENT_BYTES // 8)
    start = -room.ctypes.data % ALIGNMENT_BYTES // 8
    return room[start : start + count]


def choose_device(
    configured: str = "auto", *, option: str | None = None, work_items: int | None = None
) -> Device:
    """The device whose platform or name contains what is asked for (any case).

    The command line's ``option`` goes before the environment variable SQUEEZEFILM_DEVICE, and that
    before what is ``configured``. ``auto`` takes a processor: another device is taken when it is
    named, and has to prove itself (self_test.py). Among those that match GPUs go first, then PoCL,
    for which kernels are tuned.

    Raises:
        InputError: when no matching device computes in double precision.
    """
    return _choose_device(option or os.environ.get(DEVICE_ENV_VARIABLE) or configured, work_items)


@cache
def _choose_device(wanted: str, work_items: int | None) -> Device:
    devices = []
    rejected = []
    for device in list_devices():
        name = device_name(device)
        if wanted != "auto" and wanted.lower() not in name.lower():
            rejected.append(f"{name} (another name)")
        elif not device.double_fp_config:
            rejected.append(f"{name} (no double precision)")
        elif wanted == "auto" and not device.type & cl.device_type.CPU:
            rejected.append(f"{name} (no processor: name it to take it)")
        else:
            devices.append(device)
    if not devices:
        check_kernel_cache()
        remedy = 'an embedded one comes with: pip install "pyopencl[pocl]"'
        if rejected:
            remedy = "name one of these, or `auto`"
        elif folder := os.environ.get("OCL_ICD_VENDORS"):
            remedy = f"drivers are sought where OCL_ICD_VENDORS={folder} says: unset it"
        raise InputError(
            f"no OpenCL device with double precision matches {wanted!r}; devices found: "
            f"{'; '.join(rejected) or 'none at all'}; {remedy}"
        )
    device = min(
        devices, key=lambda each: (not each.type & cl.device_type.GPU, not _is_pocl_device(each))
    )
    context = cl.Context([device])
    on_gpu = bool(device.type & cl.device_type.GPU)
    wide = device.native_vector_width_double >= 8
    instruction_sets: tuple[str, ...] = ()
    if _is_pocl_device(device):
        wide = processor_flags().issuperset(FLAGS_FOR_64_BYTE_VECTORS)
        instruction_sets = FLAGS_FOR_64_BYTE_VECTORS if wide else ()
    return Device(
        context=context,
        queue=cl.CommandQueue(context),
        transfer_queue=cl.CommandQueue(context),
        name=device_name(device),
        work_group_count_max=device.max_compute_units * (4 if on_gpu else 1),
        work_items_per_group=work_items or (128 if on_gpu else 1),
        memory_bytes=device.global_mem_size,
        is_cpu=bool(device.type & cl.device_type.CPU),
        vector_register_bytes=64 if wide else 32,
        instruction_sets=instruction_sets,
    )


def list_devices() -> list[Any]:
    """All OpenCL devices of all platforms; an installation without a platform has none."""
    try:
        return [device for platform in cl.get_platforms() for device in platform.get_devices()]
    except cl.LogicError:
        return []


def device_name(device: Any) -> str:
    """Platform and device in one line."""
    return f"{device.platform.name.strip()}: {device.name.strip()}"


def device_properties(device: Device) -> dict[str, Any]:
    """Return the properties of the device for ``doctor`` and provenance."""
    handle = device.context.devices[0]
    return {
        "device": device.name,
        "version": handle.version.strip(),
        "driver": handle.driver_version.strip(),
        "double_precision": bool(handle.double_fp_config),
        "compute_units": handle.max_compute_units,
        "work_items_per_group": device.work_items_per_group,
        "vector_bytes": 8 * device.vector_width(8),
        "instruction_sets": " ".join(device.instruction_sets) or "as the driver chooses",
        "global_memory_bytes": handle.global_mem_size,
    }


@cache
def compiled_kernel(
    device: Device,
    name: str,
    *,
    sources: tuple[str, ...],
    header: str = "",
) -> Any:
    """A kernel of a program made of a text and some files of this folder, joined in order.

    The number of work-items per group and that of numbers in a register are always defined. Kernels
    are kept for the process and programs, by pyopencl and the driver, on disk.
    """
    sizes = (
        f"WORK_ITEMS={device.work_items_per_group}",
        f"DOUBLE_LANES={device.vector_width(8)}",
        f"FLOAT_LANES={device.vector_width(4)}",
    )
    return cl.Kernel(_cached_program(device, header, sources, sizes), name)


def run_kernel(device: Device, kernel: Any, *arguments: Any, groups: int) -> Any:
    """Let the device run a kernel and return the event of its end; numbers come with their types.

    Drivers do not keep the types with programs from a cache, and pyopencl's own call makes and
    compiles a function first.
    """
    for position, argument in enumerate(arguments):
        kernel.set_arg(position, argument)
    items = device.work_items_per_group
    return cl.enqueue_nd_range_kernel(device.queue, kernel, (groups * items,), (items,))


def _is_pocl_device(device: Any) -> bool:
    return bool(device.platform.name.strip() == "Portable Computing Language")


@cache
def check_linker(linker: str | None) -> None:
    """Raise InputError where PoCL could not link a kernel: it would end the process."""
    if linker is None:
        raise InputError(
            "PoCL links kernels by the linker ld, which is not on the PATH: install a C compiler "
            "and the C library's development files (Debian and Ubuntu: apt install gcc libc6-dev)"
        )
    import subprocess

    trial = [linker, "-shared", "-o", os.devnull, "-lc"]
    linked = subprocess.run(trial, capture_output=True, check=False, text=True, errors="replace")
    if linked.returncode:
        raise InputError(
            f"PoCL links kernels by {linker}, which cannot link the C library "
            f"({linked.stderr.strip()}): install the C library's development files "
            "(Debian and Ubuntu: apt install gcc libc6-dev; Fedora: dnf install gcc glibc-devel)"
        )


# Programs from the cache are built in a tenth of a second, others in seconds.
SLOW_BUILD_S = 1.0


@cache
def _cached_program(
    device: Device, header: str, sources: tuple[str, ...], defines: tuple[str, ...]
) -> Any:
    handle = device.context.devices[0]
    if _is_pocl_device(handle):
        # The guard of the header that builtins.cl stands for.
        sources, defines = ("builtins.cl", *sources), ("_OPENCL_H_", *defines)
    texts = [header, *((Path(__file__).parent / name).read_text("utf-8") for name in sources)]
    if device.instruction_sets:
        texts = sources_with_target_pragma(device.instruction_sets, texts)
    processor = substitute_processor_name(handle)
    if processor:
        defines = (*defines, f"PROCESSOR_{processor.replace('-', '_')}")
    source, options = "\n".join(texts), [*BUILD_OPTIONS, *(f"-D{define}" for define in defines)]
    described = [source, *options, device.name, handle.version, handle.driver_version]
    name = hashlib.sha256("\0".join(described).encode()).hexdigest()
    if not _is_pocl_device(handle) or is_cached_program_intact(name):
        return _build_program(device, source, options)
    check_linker(shutil.which("ld"))
    started_s = time.time()
    program = _build_program(device, source, options)
    if remove_damaged_programs(since_s=started_s):
        # Kept for ever: where PoCL could not read a program, it aborts when it lets go of it.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(program))
        program = _build_program(device, source, options)
    record_cached_program(name, since_s=started_s)
    return program


def _build_program(device: Device, source: str, options: Sequence[str]) -> Any:
    notice = threading.Timer(SLOW_BUILD_S, announce_compilation)
    notice.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", cl.CompilerWarning)
            return cl.Program(device.context, source).build(options=list(options))
    finally:
        notice.cancel()


def sources_with_target_pragma(instruction_sets: Sequence[str], texts: Sequence[str]) -> list[str]:
    """Return sources whose functions clang compiles for some instruction sets."""
    target = f'target("{",".join(instruction_sets)}")'
    begin = f"#pragma clang attribute push(__attribute__(({target})), apply_to = function)"
    return [begin, *texts, "#pragma clang attribute pop"]


@cache
def announce_compilation() -> None:
    """Say on the terminal, once a process, what it is waiting for."""
    print_step("compiling kernels for this device: once, up to a minute")


def substitute_processor_name(device: Any) -> str:
    """The name under which an unknown processor is compiled for; empty for all other devices.

    From then on PoCL knows it under that name. Programs are to be built with it among their
    options, for PoCL keeps those of all processors that it does not know under one name.
    """
    unknown = _is_pocl_device(device) and device.version.strip().endswith(f"-{GENERIC_PROCESSOR}")
    if not (unknown and platform.machine() == "x86_64" and CPU_INFO_FILE.exists()):
        return ""
    name = instruction_set_level(processor_flags())
    patch_pocl_processor_name(device.int_ptr, name)
    return name


def instruction_set_level(flags: frozenset[str]) -> str:
    """The highest level of which a processor has all."""
    highest = "x86-64"
    for name, added in FLAGS_OF_INSTRUCTION_SET.items():
        if not added <= flags:
            break
        highest = name
    return highest


def patch_pocl_processor_name(address: int, name: str) -> bool:
    """Make the record's pointer to ``generic`` one to ``name``; whether there was such a pointer.

    Read is through the system, which says no where memory is not the process's own.
    """
    library = ctypes.CDLL(None)
    library.strdup.restype = ctypes.c_void_p
    with Path("/proc/self/mem").open("rb", buffering=0) as memory:
        memory.seek(address)
        record = memory.read(POCL_DEVICE_RECORD_BYTES)
        for offset in range(0, len(record) - 7, 8):
            (pointer,) = struct.unpack_from("=Q", record, offset)
            try:
                memory.seek(pointer)
                text = memory.read(len(GENERIC_PROCESSOR) + 1)
            except (OSError, ValueError, OverflowError):
                continue
            if text == GENERIC_PROCESSOR.encode() + b"\0":
                own = library.strdup(name.encode())  # never freed: the device lives as long
                ctypes.c_uint64.from_address(address + offset).value = own
                return True
    return False


def processor_flags() -> frozenset[str]:
    """Return what the system says that an x86 processor can do; nothing where it does not say."""
    if not CPU_INFO_FILE.exists():
        return frozenset()
    lines = CPU_INFO_FILE.read_text(encoding="ascii", errors="replace").splitlines()
    flags_line = next((line for line in lines if line.startswith("flags")), "")
    return frozenset(flags_line.partition(":")[2].split())

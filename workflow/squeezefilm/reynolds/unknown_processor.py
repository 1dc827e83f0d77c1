"""Processors that are younger than PoCL's compiler.

LLVM calls a processor that it does not know ``generic``; PoCL 3.0 hands that name to the compiler,
which refuses it (pocl issue 1049), and has no setting for another. The name lies behind a pointer
in PoCL's record of the device: there it is replaced by the instruction set that the processor has,
in the levels of the x86-64 ABI.
"""

from __future__ import annotations

import ctypes
import platform
import struct
from pathlib import Path
from typing import Any

# What each level adds to the one before, as Linux names it.
LEVELS = {
    "x86-64-v2": {"cx16", "lahf_lm", "popcnt", "sse4_1", "sse4_2", "ssse3"},
    "x86-64-v3": {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"},
    "x86-64-v4": {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"},
}
UNKNOWN = "generic"
# The record's first bytes, among which the pointer is looked for.
RECORD_BYTES = 1024


def named(device: Any) -> str:
    """The name under which an unknown processor is compiled for; empty for all other devices.

    From then on PoCL knows it under that name. Programs are to be built with it among their
    options, for PoCL keeps those of all processors that it does not know under one name.
    """
    if device.platform.name.strip() != "Portable Computing Language":
        return ""
    if not device.version.strip().endswith(f"-{UNKNOWN}") or platform.machine() != "x86_64":
        return ""
    name = level(_flags())
    rename(device.int_ptr, name)
    return name


def level(flags: frozenset[str]) -> str:
    """The highest level of which a processor has all."""
    highest = "x86-64"
    for name, added in LEVELS.items():
        if not added <= flags:
            break
        highest = name
    return highest


def rename(address: int, name: str) -> bool:
    """Make the record's pointer to ``generic`` one to ``name``; whether there was such a pointer.

    Read is through the system, which says no where memory is not the process's own.
    """
    library = ctypes.CDLL(None)
    library.strdup.restype = ctypes.c_void_p
    with Path("/proc/self/mem").open("rb", buffering=0) as memory:
        memory.seek(address)
        record = memory.read(RECORD_BYTES)
        for place in range(0, len(record) - 7, 8):
            (pointer,) = struct.unpack_from("=Q", record, place)
            try:
                memory.seek(pointer)
                text = memory.read(len(UNKNOWN) + 1)
            except (OSError, ValueError, OverflowError):
                continue
            if text == UNKNOWN.encode() + b"\0":
                own = library.strdup(name.encode())  # never freed: the device lives as long
                ctypes.c_uint64.from_address(address + place).value = own
                return True
    return False


def _flags() -> frozenset[str]:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return frozenset()
    found = next((line for line in lines if line.startswith("flags")), "")
    return frozenset(found.partition(":")[2].split())

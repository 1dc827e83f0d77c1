"""The folders in which drivers keep compiled kernels."""

from __future__ import annotations

import os
import platform
import shutil
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from squeezefilm.errors import InputError
from squeezefilm.files import atomic_file

# Compiled kernels of a job on a cluster are kept on its node, compiled once for all jobs there. The
# drivers' caches lie in the home directory: on a cluster that is shared by nodes that may differ,
# over a network whose file locks may not work. The workflow therefore names, in jobs on other
# nodes, a folder of the node's own disk.
NODE_CACHE_ENV_VARIABLE = "SQUEEZEFILM_NODE_CACHE"
# A shared disk's clock may be another.
MAX_CLOCK_DIFFERENCE_S = 10.0
ELF_HEADER_BYTES = 64
# Of a program's folder: its kernels, linked. And where programs are known by names of ours.
LINKED_KERNEL_PATTERN, PROGRAM_NAMES_FOLDER = "*/*/*.so", "squeezefilm"


def kernel_cache_folder() -> Path:
    """Return the folder in which PoCL keeps compiled kernels."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return Path(os.environ.get("POCL_CACHE_DIR") or home / "pocl" / "kcache")


def check_kernel_cache() -> None:
    """Raise InputError where PoCL cannot write compiled kernels: it then has no device."""
    folder = kernel_cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"PoCL keeps compiled kernels in {folder}, which cannot be written "
            f"({error.strerror}): name a folder that can, for example "
            "export POCL_CACHE_DIR=/tmp/pocl XDG_CACHE_HOME=/tmp"
        ) from None


def is_cached_program_intact(name: str) -> bool:
    """Return whether a program that ``record_cached_program`` has named is whole in PoCL's cache,
    and linked."""
    try:
        program = kernel_cache_folder() / (
            kernel_cache_folder() / PROGRAM_NAMES_FOLDER / name
        ).read_text("utf-8")
        return any(program.glob(LINKED_KERNEL_PATTERN)) and _is_intact_program(program)
    except OSError:
        return False


def record_cached_program(name: str, *, since_s: float) -> None:
    """Name the program that PoCL has used since then, where it is just one, for
    ``is_cached_program_intact``.

    Looking for it among all programs of a large cache takes longer than it takes to load.
    """
    used = list(_programs_used_since(since_s=since_s))
    if len(used) == 1:
        with (
            suppress(InputError),
            atomic_file(kernel_cache_folder() / PROGRAM_NAMES_FOLDER / name) as path,
        ):
            path.write_text(str(used[0].relative_to(kernel_cache_folder())), "utf-8")


def remove_damaged_programs(*, since_s: float) -> bool:
    """Remove programs, of those that PoCL took from its cache, that are cut short.

    A full disk or a broken copy leaves such. PoCL takes code without its end for a program without
    kernels, and the system ends a process that loads a library without its end.

    Args:
        since_s: the time of the system's clock before the programs were built, in s.

    Returns:
        Whether there were any: they are then to be built again.
    """
    damaged = [
        each
        for each in _programs_used_since(since_s=since_s - MAX_CLOCK_DIFFERENCE_S)
        if not _is_intact_program(each)
    ]
    for program in damaged:
        shutil.rmtree(program, ignore_errors=True)
    return bool(damaged)


def _programs_used_since(*, since_s: float) -> Iterator[Path]:
    for accessed in kernel_cache_folder().glob("*/*/last_accessed"):  # PoCL's mark of a use
        with suppress(OSError):  # another process removes it
            if accessed.stat().st_mtime >= since_s:
                yield accessed.parent


def _is_intact_program(program: Path) -> bool:
    try:
        return all(
            map(is_complete_binary, [program / "program.bc", *program.glob(LINKED_KERNEL_PATTERN)])
        )
    except OSError:
        return True  # another process removes it


def is_complete_binary(path: Path) -> bool:
    """Return whether a file of LLVM's code or a library (ELF) has the length that it states."""
    content = path.read_bytes()
    if content.startswith(b"\x7fELF") and len(content) > ELF_HEADER_BYTES:
        (table,) = struct.unpack_from("<Q", content, 40)
        size, number = struct.unpack_from("<HH", content, 58)
        return bool(table + size * number <= len(content))
    if not content.startswith(b"BC\xc0\xde"):
        return False
    # Blocks one after the other, of which the second is the program: a word, its length, its words.
    blocks, end = 0, 4
    while end + 8 <= len(content):
        (words,) = struct.unpack_from("<I", content, end + 4)
        blocks, end = blocks + 1, end + 8 + 4 * words
    return blocks > 1 and end == len(content)


@contextmanager
def build_lock() -> Iterator[None]:
    """Choose the device and build within: from the node's cache, or waiting for who fills it.

    The lock goes with the process that holds it, however that ends.
    """
    folder = _node_cache_folder()
    if folder is None:
        yield
        return
    import fcntl

    os.environ["POCL_CACHE_DIR"] = str(folder / "pocl")
    os.environ["XDG_CACHE_HOME"] = str(folder)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _node_cache_folder() -> Path | None:
    """The node's folder for this user; None where none is named, or it cannot be had.

    It must be the user's own, for what lies in it is run.
    """
    if not os.environ.get(NODE_CACHE_ENV_VARIABLE):
        return None
    # A user's own folder, and a host's: where the disk is shared after all, nodes do not meet.
    folder = (
        Path(os.environ[NODE_CACHE_ENV_VARIABLE]) / f"squeezefilm-{os.getuid()}" / platform.node()
    )
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        owner = folder.parent.lstat()
        if owner.st_uid != os.getuid() or owner.st_mode & 0o022:
            return None
        folder.mkdir(exist_ok=True)
    except OSError:
        return None
    return folder

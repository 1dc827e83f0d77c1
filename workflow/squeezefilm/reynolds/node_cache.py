"""Compiled kernels of a job on a cluster: kept on its node, compiled once for all jobs there.

The drivers' caches lie in the home directory. On a cluster that is shared by nodes that may differ,
over a network whose file locks may not work. The workflow therefore names, in jobs on other nodes,
a folder of the node's own disk in the environment variable SQUEEZEFILM_NODE_CACHE.
"""

import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

VARIABLE = "SQUEEZEFILM_NODE_CACHE"


@contextmanager
def one_build_at_a_time() -> Iterator[None]:
    """Choose the device and build within: from the node's cache, or waiting for who fills it.

    The lock goes with the process that holds it, however that ends.
    """
    folder = _own_folder()
    if folder is None:
        yield
        return
    import fcntl

    os.environ["POCL_CACHE_DIR"] = str(folder / "pocl")
    os.environ["XDG_CACHE_HOME"] = str(folder)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _own_folder() -> Path | None:
    """The node's folder for this user; None where none is named, or it cannot be had.

    It must be the user's own, for what lies in it is run.
    """
    if not os.environ.get(VARIABLE):
        return None
    # A user's own folder, and a host's: where the disk is shared after all, nodes do not meet.
    folder = Path(os.environ[VARIABLE]) / f"squeezefilm-{os.getuid()}" / platform.node()
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        owner = folder.parent.lstat()
        if owner.st_uid != os.getuid() or owner.st_mode & 0o022:
            return None
        folder.mkdir(exist_ok=True)
    except OSError:
        return None
    return folder

"""A Debian in a folder, as it comes: no compiler cache, no package but those that are named."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

USER = "newcomer"
# With mounts and processes of its own, which go with the command.
WITHIN = """
mount -t proc proc "$1/proc" && mount --rbind /dev "$1/dev" && shift 1 && exec "$@"
"""
ARCHIVE_KEYS = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
SOURCES = Path("/etc/apt/sources.list.d/debian.sources"), Path("/etc/apt/sources.list")


@dataclass(frozen=True)
class Machine:
    """A root folder, and what leads from it to the registries as from this machine."""

    root: Path
    environment: dict[str, str]

    @property
    def clone(self) -> Path:
        """Return the folder of the clone, as this machine sees it."""
        return self.root / "home" / USER / "squeezefilm"

    def run(self, command: str, *, user: str = USER) -> str:
        """Run a command of the shell in the user's clone and return what it prints."""
        home = "/root" if user == "root" else f"/home/{user}"
        set_variables = {"HOME": home, "PATH": "/usr/sbin:/usr/bin:/sbin:/bin", **self.environment}
        changed = "cd ~/squeezefilm 2>/dev/null;" if user != "root" else "cd /;"
        done = subprocess.run(
            [
                *(
                    "unshare",
                    "--mount",
                    "--pid",
                    "--fork",
                    "sh",
                    "-c",
                    WITHIN,
                    "sh",
                    str(self.root),
                ),
                *("/usr/sbin/chroot", f"--userspec={user}:{user}", str(self.root)),
                *("env", "-i", *(f"{name}={value}" for name, value in set_variables.items())),
                *("sh", "-c", f"{changed} {command}"),
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout[-6000:]}"
        return done.stdout


def missing_for_a_machine() -> str:
    """Return what keeps this machine from making another; empty where nothing does."""
    if os.getuid() != 0:
        return "needs root"
    if shutil.which("mmdebstrap") is None:
        return "mmdebstrap is not installed (Debian: mmdebstrap)"
    return "" if _mirror() else "no Debian mirror is named in the sources of this machine"


@contextmanager
def fresh_machine(release: str, repository: Path) -> Iterator[Machine]:
    """Set up a minimal Debian with a user in it who has cloned the repository."""
    source = f"deb [signed-by={ARCHIVE_KEYS}] {_mirror()} {release} main"
    with tempfile.TemporaryDirectory(prefix=f"squeezefilm-{release}-") as folder:
        root = Path(folder) / "root"
        make = ["mmdebstrap", "--quiet", "--variant=minbase", "--mode=root", release, root, source]
        subprocess.run(make, check=True)
        machine = Machine(root, _network(root))
        machine.run(f"useradd --create-home {USER}", user="root")
        clone = ["git", "clone", "--quiet", "--no-hardlinks", repository, machine.clone]
        subprocess.run(clone, check=True)
        machine.run(f"chown -R {USER}:{USER} /home/{USER}", user="root")
        yield machine


def _mirror() -> str:
    """Return the address from which this machine has its Debian packages."""
    words = [word for path in SOURCES if path.exists() for word in path.read_text().split()]
    return next((word for word in words if "://" in word and word.endswith("/debian")), "")


def _network(root: Path) -> dict[str, str]:
    """Give a root folder the names and certificates of this machine; return the variables."""
    files = {Path("/etc/resolv.conf"), Path("/etc/hosts"), Path("/etc/pip.conf")}
    variables = {
        name: value
        for name, value in os.environ.items()
        if name.lower().endswith("_proxy") or name in ("PIP_CERT", "PIP_INDEX_URL")
    }
    if certificates := variables.get("PIP_CERT"):
        variables["PIP_CERT"] = "/etc/machine-certificates.crt"
        shutil.copy(certificates, root / "etc/machine-certificates.crt")
    for path in files:
        if path.exists():
            shutil.copy(path, root / path.relative_to("/"))
    return variables

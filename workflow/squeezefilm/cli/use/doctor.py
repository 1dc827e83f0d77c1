"""Check this installation: OpenCL device, caches, versions.

Ends with status 1 when there is no OpenCL device that computes in double precision.
"""

import argparse
import os
from pathlib import Path

from squeezefilm.errors import InputError, RunError
from squeezefilm.provenance import versions
from squeezefilm.reynolds.device import (
    DEVICE_VARIABLE,
    choose_device,
    describe,
    device_name,
    list_devices,
)
from squeezefilm.reynolds.self_test import check_device


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--device", help="part of the wanted device's name, instead of SQUEEZEFILM_DEVICE"
    )


def run(options: argparse.Namespace) -> None:
    _section("versions", versions())
    _section("caches", caches())
    try:
        _section("devices", {device_name(device): _kind(device) for device in list_devices()})
        device = choose_device(option=options.device)
        _section("chosen device", describe(device))
    except ImportError as error:
        raise RunError(
            f'pyopencl cannot be imported ({error}); install it: pip install "pyopencl[pocl]"'
        ) from None
    except InputError as error:
        raise RunError(
            f"{error}. A device is chosen by --device, by the environment variable "
            f"{DEVICE_VARIABLE}, or by solver.device of the configuration"
        ) from None
    check_device(device)
    print("  self-test: forces of stored films, with every term, are right to 1e-9")
    print("\nall well: simulations can run")


def caches() -> dict[str, str]:
    """Where compiled kernels are kept, and whether that can be written."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folders = {
        "PoCL (POCL_CACHE_DIR)": Path(os.environ.get("POCL_CACHE_DIR") or home / "pocl" / "kcache"),
        "pyopencl (XDG_CACHE_HOME)": home / "pyopencl",
        "pytools (XDG_CACHE_HOME)": home / "pytools",
    }
    return {name: f"{folder}: {_folder_state(folder)}" for name, folder in folders.items()}


def _folder_state(folder: Path) -> str:
    if not folder.exists():
        return "not made yet"
    if not (folder.is_dir() and os.access(folder, os.W_OK)):
        return "NOT WRITABLE: kernels are compiled again in every job"
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    return f"{size / 2**20:.1f} MiB"


def _kind(device: object) -> str:
    precise = (
        "double precision" if getattr(device, "double_fp_config", 0) else "single precision only"
    )
    return f"{getattr(device, 'version', '').strip()}, {precise}"


def _section(title: str, values: dict[str, object] | dict[str, str]) -> None:
    print(f"\n{title}")
    for name, value in values.items() or {"none": ""}.items():
        print(f"  {name}: {value}")

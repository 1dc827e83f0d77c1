"""Commands to begin with: a new study, a study as it is computed, the installation."""

import argparse
import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from squeezefilm.cli.options import command, flag_option, option, print_notes
from squeezefilm.config.loading import (
    FilmWithoutStudyError,
    load_config,
    load_film,
    parse_config,
)
from squeezefilm.config.notes import study_notes
from squeezefilm.config.study import Study
from squeezefilm.config.writing import effective_yaml
from squeezefilm.errors import InputError, RunError
from squeezefilm.files import read_text, write_text
from squeezefilm.formatting import result_lines_text
from squeezefilm.models.force_model import check_models_of_study, model_notes
from squeezefilm.provenance import package_versions
from squeezefilm.reynolds.device import choose_device, device_name, device_properties, list_devices
from squeezefilm.reynolds.kernel_cache import kernel_cache_folder
from squeezefilm.studies.plans import chunk_counts
from squeezefilm.studies.study import check_film, check_study

EXAMPLE_STUDY_PATH = Path(__file__).resolve().parents[3] / "config" / "vibrometer"
# What a rectangular surface has instead of the example's, by the text before and after.
RECTANGLE_REPLACEMENTS = {
    "a disc (or the disc around what is measured)": "a rectangle",
    "surface_radius: 10 mm": "surface: {shape: rectangle, length_x: 60 mm, length_y: 40 mm}",
    """\
  # The vibrometer's table, beside this file: x and y (or r), amplitude, phase, with units in its
  # header. Other shapes: sinc, piston, standing-wave, travelling-wave, bessel, formula.
  profile: {kind: measured, file: vibrometer.csv, axisymmetric: true}
""": """\
  # A vibrometer's table beside this file, with x, y, amplitude and phase, and units in its header:
  # {kind: measured, file: scan.csv}. Other shapes: piston, travelling-wave, formula.
  profile: {kind: standing-wave, wavelength: 12 mm}
""",
    "extrapolation: #": """\
models: # along a standing wave the force repeats twice in a wavelength
  wave:
    expression: >-
      (t0 + t1*cos(4*pi*x/wavelength))*(hv/h0)**2 + (t2 + t3*cos(4*pi*x/wavelength))*(hv/h0)**4
    constants: {wavelength: 12 mm} # the profile's

comparison:
  four_factor: [four_factor, limit_2, wave] # limit_2: rectangular pads only

positions: # pad centres of interest, on one side
  x: [3 mm, 20 mm] # node line (a quarter wavelength), and the farthest pad centre
  y: [10 mm]

extrapolation: #""",
}


@command(
    option("name", "NAME", "of the study: a-z, 0-9, - and _"),
    option("--folder", help="where to write; default config", default="config"),
    flag_option(
        "--rectangle", "begin with a rectangular plate and its standing wave, without a table"
    ),
)
def new(options: argparse.Namespace) -> None:
    """Begin a study of your own actuator.

      squeezefilm new my-actuator

    writes config/my-actuator.yaml, a study of twenty lines that says what differs from the
    defaults, and config/my-actuator.csv, a vibrometer's table to replace by yours; with
    `--rectangle` the study of a plate alone. Neither is written if one of them is there already.
    Both run as they are; `squeezefilm config` shows every other key:

      snakemake --configfile config/my-actuator.yaml
    """
    name, folder, example = options.name, Path(options.folder), EXAMPLE_STUDY_PATH.name
    config, scan = folder / f"{name}.yaml", folder / f"{name}.csv"
    files = [config, *[scan] * (not options.rectangle)]
    for path in files:
        if path.exists():
            raise InputError(f"{path}: is there already; choose another name, or remove it")
    what = "example; `squeezefilm new` needs a checkout of the workflow"
    text = read_text(f"{EXAMPLE_STUDY_PATH}.yaml", what=what)
    for old, named in (
        *(RECTANGLE_REPLACEMENTS.items() if options.rectangle else ()),
        (f"{example}.csv", f"{name}.csv"),
        (f"study: {example} ", f"study: {name} "),
        (f"results/{example}", f"results/{name}"),
        ("THIS_FILE", f"config/{name}.yaml"),
    ):
        text = text.replace(old, named)
    try:
        parse_config(text, path=config)
    except InputError:  # of an example with another name
        close = re.sub("[^a-z0-9_-]+", "-", name.lower().removesuffix(".yaml")).strip("-_")[:60]
        hint = f"; did you mean {close!r}?" * bool(close)
        allowed = "lower-case letters, digits, `_`, `-`, at most 60, first a letter or a digit"
        raise InputError(f"{name!r} is no name of a study: {allowed}{hint}") from None
    write_text(text, config)
    print(f"{config}: the study; change what is yours")
    if scan in files:
        write_text(read_text(f"{EXAMPLE_STUDY_PATH}.csv", what=what), scan)
        print(f"{scan}: an example of a vibrometer's table; replace it by yours")
    print(f"Then: snakemake --configfile {config}")


@command(
    option("study", "STUDY.yaml", "the study", nargs="?"),
    flag_option("--schema", "print the keys' JSON schema instead"),
)
def config(options: argparse.Namespace) -> None:
    """Show all keys of a study: values in SI units, and the origin of those that it does not write.

      squeezefilm config config/my-actuator.yaml

    All that is invalid for a run is reported; notes name numbers that may lack a unit and models
    that no run would fit. What is not marked was written; `default` is the library's, `derived`
    follows from what was written. The text is a study itself. A run writes it beside its results:
    results/STUDY/study.yaml. A file with a film alone is shown too. `--schema` prints a study's
    JSON schema, for editors.
    """
    if options.schema:
        print(json.dumps(Study.model_json_schema(), ensure_ascii=False, indent=2))
        return
    if options.study is None:
        raise InputError("give a study, STUDY.yaml")
    try:
        study = check_study(load_config(options.study))
    except FilmWithoutStudyError as film_alone:
        film = load_film(options.study)
        check_film(film)
        print(effective_yaml(film), end="")
        print_notes([str(film_alone)])
        return
    check_models_of_study(study)
    chunk_counts(study)
    print(effective_yaml(study), end="")
    print_notes(study_notes(study))
    print_notes(model_notes(study))


@command(option("--device", help="part of the wanted one's name, instead of SQUEEZEFILM_DEVICE"))
def doctor(options: argparse.Namespace) -> None:
    """Check this installation: OpenCL device, caches, versions.

    A self-test solves stored films with every kernel; compiling these takes minutes the first time.
    Ends with status 1 when there is no OpenCL device that computes in double precision.
    """
    from squeezefilm.reynolds.self_test import check_device, check_force_in_new_process

    _print_section("versions", package_versions())
    _print_section("caches", cache_folder_states())
    try:
        _print_section(
            "devices",
            {device_name(device): _device_description(device) for device in list_devices()},
        )
        device = choose_device(option=options.device)
        _print_section("chosen device", device_properties(device))
        if len(list_devices()) > 1:
            print(
                "of several that match GPUs are taken first, then PoCL, for which kernels are tuned"
            )
    except ImportError as error:
        raise RunError(
            f'pyopencl cannot be imported ({error}); install it: pip install "pyopencl[pocl]"'
        ) from None
    except InputError as error:
        raise RunError(
            f"{error}. A device is chosen by --device, by the environment variable "
            "SQUEEZEFILM_DEVICE, or by solver.device of the configuration"
        ) from None
    check_force_in_new_process(options.device)
    check_device(device)
    print("self-test: forces of stored films, with every term, are right to 1e-9")
    print("\nall well: simulations can run")


def cache_folder_states() -> dict[str, str]:
    """Report the folders of compiled kernels, and if they can be written."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folders = {"PoCL (POCL_CACHE_DIR)": kernel_cache_folder()}
    folders |= {f"{name} (XDG_CACHE_HOME)": home / name for name in ("pyopencl", "pytools")}
    return {name: f"{folder}: {_folder_state_text(folder)}" for name, folder in folders.items()}


def _folder_state_text(folder: Path) -> str:
    if not folder.exists():
        return "not made yet"
    if not (folder.is_dir() and os.access(folder, os.W_OK)):
        return "NOT WRITABLE: kernels are compiled again in every job"
    return "can be written"


def _device_description(device: Any) -> str:
    precise = "double precision" if device.double_fp_config else "single precision only"
    return f"{device.version.strip()}, {precise}"


def _print_section(title: str, values: Mapping[str, object]) -> None:
    print(f"\n{title}", result_lines_text(values) if values else "none", sep="\n")

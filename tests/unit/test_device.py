"""The device: chosen by name, refused with a reason, never asked for more than it has."""

import io
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from squeezefilm.api.forces import compile_kernels
from squeezefilm.cli import setup
from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.reynolds import device, self_test, solve
from squeezefilm.reynolds.device import DEVICE_ENV_VARIABLE, choose_device
from squeezefilm.studies.study import check_study


@pytest.mark.parametrize("said", [None, ""])  # an empty variable is none
def test_a_device_that_is_not_there_is_refused_with_those_that_are(said, monkeypatch):
    monkeypatch.delenv(DEVICE_ENV_VARIABLE, raising=False)
    if said is not None:
        monkeypatch.setenv(DEVICE_ENV_VARIABLE, said)
    with pytest.raises(InputError, match=r"no OpenCL device with double precision.*found: .*: "):
        choose_device("no such device")


def test_an_option_goes_before_the_environment_and_that_before_the_configuration(
    monkeypatch, capsys, refused
):
    monkeypatch.setenv(DEVICE_ENV_VARIABLE, "no such device")
    one = ["simulate", "--h0", "5um", "--hv", "1um", "--tolerance", "1e-4"]
    assert main([*one, "--device", "auto"]) == 0
    assert main(["doctor", "--device", "portable computing"]) == 0
    capsys.readouterr()
    assert "matches 'another'" in refused(*one, "--device", "another")
    assert "matches 'no such device'" in refused(*one)


def test_pocl_is_not_asked_for_a_kernel_that_it_compiles_for_minutes():
    scene, _ = self_test.test_cases()["inertia"]
    with pytest.raises(InputError, match="inertia for work-groups of 4 items for many"):
        solve([scene], tolerance=1e-2, method="periodic", device=choose_device(work_items=4))


def test_kernels_are_compiled_for_a_study_of_any_gap(edited):
    """A pad tilted by 15 µm over gaps of 10–20 µm is a film; at 5 µm it would be none."""
    gaps = {"h0_m": {"start": 10e-6, "stop": 20e-6, "levels": 3}}
    tilted = {"gap": {"tilt_x_m": 15e-6, "tilt_y_m": 0, "crown_m": 0}}
    config = edited(pad=tilted, screen=gaps, error_map=gaps, extrapolation={"h0_m": 10e-6})
    check_study(load_config(config))
    assert "device" in compile_kernels(load_config(config))


def test_a_device_whose_kernel_has_a_wrong_sign_is_refused(monkeypatch, refused):
    """As if its compiler had made a plus of a minus."""
    sound = Path.read_text

    def compiled_wrongly(path, *arguments, **options):
        text = sound(path, *arguments, **options)
        if path.name == "inertia_over_period.cl":
            wrong = text.replace("rate)[i] - u[i] * filling", "rate)[i] + u[i] * filling", 1)
            assert wrong != text
            return wrong
        return text

    films = {
        name: film for name, film in self_test.test_cases().items() if name in ("inertia", "slip")
    }
    stored = pd.read_csv(self_test.STORED_FORCES_PATH, index_col="film").loc[[*films]].to_csv()
    monkeypatch.setattr(self_test, "test_cases", lambda: films)
    monkeypatch.setattr(self_test, "STORED_FORCES_PATH", io.StringIO(stored))
    monkeypatch.setattr(Path, "read_text", compiled_wrongly)
    caches = (device.compiled_kernel, device._cached_program, self_test._failed_cases_text)
    try:
        [each.cache_clear() for each in caches]
        message = refused("doctor")
    finally:
        [each.cache_clear() for each in caches]
    assert "fails its self-test" in message
    assert "inertia: " in message
    assert "slip: " not in message


def test_pocl_goes_before_another_driver_of_the_processor(monkeypatch, capsys):
    """Intel's OpenCL may be listed first; kernels are tuned for PoCL."""
    (pocl, *_) = [each for each in device.list_devices() if device._is_pocl_device(each)]
    platform = SimpleNamespace(name="Intel(R) OpenCL")
    other = SimpleNamespace(
        platform=platform, name="cpu", version="3", type=pocl.type, double_fp_config=1
    )
    monkeypatch.setattr(device, "list_devices", lambda: [other, pocl])
    monkeypatch.setattr(setup, "list_devices", device.list_devices)
    assert device._choose_device.__wrapped__("auto", None).context.devices == [pocl]
    assert main(["doctor"]) == 0
    assert "then PoCL, for which kernels are tuned" in capsys.readouterr().out


AVX_512 = "flags : fma avx2 avx512f avx512dq avx512cd avx512bw avx512vl"


@pytest.mark.parametrize(("flags", "numbers"), [(AVX_512, 8), (AVX_512[:-9], 4), ("", 4)])
def test_vectors_are_those_of_the_processor_and_no_warning_is_printed(
    flags, numbers, monkeypatch, tmp_path, capfd
):
    """PoCL's compiler takes many processors for older ones, without AVX-512."""
    if "Portable Computing Language" not in choose_device().name:
        pytest.skip("of PoCL alone")
    told = tmp_path / "cpuinfo"
    told.write_text(f"processor : 0\n{flags}\n")
    monkeypatch.setattr(device, "CPU_INFO_FILE", told)
    chosen = device._choose_device.__wrapped__("auto", None)
    square = tmp_path / "square.cl"
    square.write_text("kernel void square(vector a) { multiply(a, 4, 4, a, a, 4, 1, 0); }\n")
    sources = ("linear_algebra.cl", "vectors.cl", str(square))
    device.compiled_kernel(chosen, "square", sources=sources, header=f"// {tmp_path}: in no cache")
    assert chosen.vector_width(8) == numbers
    assert device.device_properties(chosen)["vector_bytes"] == 8 * numbers
    assert "warnings generated" not in capfd.readouterr().err


def test_a_driver_that_keeps_no_types_of_arguments_solves(monkeypatch):
    """Intel's keeps none with programs that come from its cache."""

    def get_arg_info(*_):
        raise AssertionError("clGetKernelArgInfo failed: KERNEL_ARG_INFO_NOT_AVAILABLE")

    monkeypatch.setattr("pyopencl.Kernel.get_arg_info", get_arg_info)
    device.compiled_kernel.cache_clear()
    scene, _ = self_test.test_cases()["squeeze"]
    assert solve([scene], tolerance=1e-3, method="periodic")[0].status == "ok"


def test_a_missing_linker_is_told_before_pocl_dies_of_it(monkeypatch, tmp_path):
    chosen = choose_device()
    if "Portable Computing Language" not in chosen.name:
        pytest.skip("of PoCL alone")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="apt install gcc"):
        device.compiled_kernel(chosen, "none", sources=(), header="// not built")


def test_a_linker_without_the_c_library_is_told_before_pocl_dies_of_it(monkeypatch, tmp_path):
    """Debian's gcc without the recommended libc6-dev; PoCL aborts the process."""
    chosen = choose_device()
    if "Portable Computing Language" not in chosen.name:
        pytest.skip("of PoCL alone")
    linker = tmp_path / "ld"
    linker.write_text("#!/bin/sh\necho 'ld: cannot find -lc: No such file' >&2\nexit 1\n")
    linker.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(InputError, match=r"cannot find -lc.*apt install gcc libc6-dev"):
        device.compiled_kernel(chosen, "none", sources=(), header="// not built")


def test_a_cache_that_cannot_be_written_is_named_with_the_remedy(tmp_path):
    """As on compute nodes whose home is read-only: PoCL then has no device at all."""
    file = tmp_path / "file"
    file.touch()
    told = subprocess.run(
        [sys.executable, "-m", "squeezefilm", "simulate", "--h0", "5um", "--hv", "1um"],
        env={**os.environ, "POCL_CACHE_DIR": str(file / "pocl")},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    if told.returncode == 0:
        pytest.skip("of PoCL alone")
    assert told.returncode == 2
    assert f"PoCL keeps compiled kernels in {file / 'pocl'}" in told.stderr
    assert "POCL_CACHE_DIR=" in told.stderr


FORKED = """
import os
from squeezefilm.errors import InputError
from squeezefilm.reynolds import self_test, solve
scene, _ = self_test.test_cases()["squeeze"]
solve([scene], tolerance=1e-3, method="periodic")
child = os.fork()
try:
    solve([scene], tolerance=1e-3, method="periodic")
except InputError as error:
    print(error, flush=True)
if child:
    os.waitpid(child, 0)
"""


def test_a_force_in_a_forked_process_is_refused_with_a_sentence():
    """PoCL's threads are not in the child, which would wait for them for ever."""
    told = subprocess.run(
        [sys.executable, "-c", FORKED], capture_output=True, text=True, timeout=30, check=True
    )
    assert "the OpenCL device belongs to process" in told.stdout


def test_a_cold_cache_is_filled_once_and_gives_the_same_force(tmp_path):
    table = tmp_path / "scenes.csv"
    table.write_text("point_id,h0_m,hv_m,x_m,y_m\n1,5e-6,1e-6,0,0\n", encoding="utf-8")
    caches = {"POCL_CACHE_DIR": str(tmp_path / "pocl"), "XDG_CACHE_HOME": str(tmp_path / "cache")}

    def forces(environment: dict[str, str]) -> str:
        output = tmp_path / "forces.csv"
        words = ("simulate", str(table), "--output", str(output), "--tolerance", "1e-3")
        subprocess.run(
            [sys.executable, "-m", "squeezefilm", *words],
            env={**os.environ, **environment},
            capture_output=True,
            timeout=300,
            check=True,
        )
        return output.read_text(encoding="utf-8")

    def compiled() -> set[Path]:
        return {path for name in ("pocl", "cache") for path in (tmp_path / name).rglob("*.so")}

    cold, known = forces(caches), compiled()
    assert cold == forces(caches) == forces({})
    if "Portable Computing Language" in choose_device().name:
        assert known
    assert compiled() == known

"""On a cluster's node kernels lie in the user's own folder there, and are built by one job."""

import multiprocessing
import os
import time
from pathlib import Path

import pytest

from squeezefilm.reynolds import kernel_cache


@pytest.fixture(autouse=True)
def caches(monkeypatch):
    for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME", kernel_cache.NODE_CACHE_ENV_VARIABLE):
        monkeypatch.setenv(name, "elsewhere")  # so that it is put back afterwards
        monkeypatch.delenv(name)


def test_both_caches_go_to_the_named_folder(tmp_path, monkeypatch):
    monkeypatch.setenv(kernel_cache.NODE_CACHE_ENV_VARIABLE, str(tmp_path / "scratch"))
    with kernel_cache.build_lock():
        for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME"):
            assert Path(os.environ[name]).is_relative_to(tmp_path / "scratch")
    (own,) = (tmp_path / "scratch").iterdir()
    assert own.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("folder", [None, "open to others"])
def test_a_folder_that_is_not_one_s_own_is_not_used(folder, tmp_path, monkeypatch):
    if folder:
        own = tmp_path / "scratch" / f"squeezefilm-{os.getuid()}"
        own.mkdir(parents=True)
        own.chmod(0o777)
        monkeypatch.setenv(kernel_cache.NODE_CACHE_ENV_VARIABLE, str(tmp_path / "scratch"))
    with kernel_cache.build_lock():
        assert "POCL_CACHE_DIR" not in os.environ


def build(log: Path) -> None:
    with kernel_cache.build_lock():
        for word in ("begin", "end"):
            with log.open("a") as handle:
                handle.write(f"{word}\n")
            time.sleep(0.05)


def test_jobs_build_one_after_the_other(tmp_path, monkeypatch):
    monkeypatch.setenv(kernel_cache.NODE_CACHE_ENV_VARIABLE, str(tmp_path))
    log = tmp_path / "log"
    fork = multiprocessing.get_context("fork")
    processes = [fork.Process(target=build, args=(log,)) for _ in range(3)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert log.read_text().split() == ["begin", "end"] * 3

"""The device: chosen by name, refused with a reason, never asked for more than it has."""

from __future__ import annotations

from dataclasses import replace

import pytest

from squeezefilm.errors import InputError
from squeezefilm.reynolds.device import DEVICE_VARIABLE, choose_device


def test_a_device_that_is_not_there_is_refused_with_those_that_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv(DEVICE_VARIABLE, raising=False)
    with pytest.raises(InputError, match=r"no OpenCL device with double precision.*found: .*: "):
        choose_device("no such device")


def test_the_environment_goes_before_the_configuration(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(DEVICE_VARIABLE, "no such device")
    with pytest.raises(InputError, match="no such device"):
        choose_device("auto")


def test_groups_stay_within_the_scenes_and_half_the_memory() -> None:
    device = replace(choose_device(), groups=528, memory_bytes=80 * 2**30)
    assert device.groups_for(10_000, workspace_bytes=7 * 2**20) == 528
    assert device.groups_for(3, workspace_bytes=7 * 2**20) == 3
    assert device.groups_for(10_000, workspace_bytes=256 * 2**20) == 160
    assert device.groups_for(10_000, workspace_bytes=2**40) == 1

"""What leaving things out saves is measured beside a reference from the same device."""

from films import film

from numerics.left_out import measure
from squeezefilm.reynolds.device import DEVICE_VARIABLE, choose_device


def test_the_reference_is_solved_on_the_device_that_is_measured(monkeypatch):
    device = choose_device()
    monkeypatch.setenv(DEVICE_VARIABLE, "no such device")
    scenes = [film(epsilon=0.2, sigma=583.0)]
    variants = measure(scenes, tolerances=[1e-4], reference=1e-7, repeats=1, device=device)
    assert len(variants) > 3
    assert all(0 < each.worst_error < 1e-4 for each in variants)

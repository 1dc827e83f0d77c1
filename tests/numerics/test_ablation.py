"""What leaving things out saves is measured beside a reference from the same device."""

from films import film

from squeezefilm.reynolds.device import DEVICE_ENV_VARIABLE, choose_device
from squeezefilm_workflow.verification.ablation import ablation_table


def test_what_is_put_back_changes_no_force_and_is_solved_on_that_device(monkeypatch):
    device = choose_device()
    monkeypatch.setenv(DEVICE_ENV_VARIABLE, "no such device")
    scenes = [film(epsilon=0.2, sigma=583.0)]
    table = ablation_table(scenes, tolerances=[1e-4], repeats=1, device=device).set_index(
        "re_enabled"
    )
    assert {"nothing", "symmetry", "Couette term", "everything"} < set(table.index)
    assert table["worst_error"].between(0, 1e-4, inclusive="neither").all()
    assert (table.drop("everything, in NumPy")["coverage"] == 1).all()
    assert table.at["nothing", "cpu_ratio"] == 1
    assert table.at["everything", "cpu_ratio"] > 5

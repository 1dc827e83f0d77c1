"""What is made from a study's scan, outline or measurements is made anew where its file changes."""

import pytest
from example_outline import STUDY, write_outline

from .conftest import copy_checkout, snakemake


@pytest.mark.parametrize(
    ("study", "target", "message"),
    [
        ("vibrometer", "profile/smoothed.npz", "Make a smooth profile of the scan"),
        ("synthetic", "measurements/summary.json", "Measured forces beside computed ones"),
        ("patch", "simulations/device.json", "Compile the kernels"),
    ],
)
def test_a_changed_file_is_read_again(study, target, message, repository, tmp_path):
    folder = copy_checkout(repository, tmp_path / "checkout")
    still = "gas: {inertia: none, thermal: none}\n"
    (folder / "config/patch.yaml").write_text(STUDY + still, encoding="utf-8")
    write_outline(folder / "config")
    words = (f"results/{study}/{target}", "--configfile", f"config/{study}.yaml")
    done = snakemake(folder, *words)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Nothing to be done" in snakemake(folder, *words).stdout
    with (folder / f"config/{study}.csv").open("a", encoding="utf-8") as file:
        file.write("\n")
    assert message in snakemake(folder, *words, "--dry-run").stdout

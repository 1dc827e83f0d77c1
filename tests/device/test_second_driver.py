"""Another OpenCL of the same processor, where one is installed, gives what PoCL gives.

Intel's: pip install intel-opencl-rt intel-cmplr-lib-rt; a folder named by OCL_ICD_VENDORS has a
file whose name ends in .icd, with the path of libintelocl.so; its folder is in LD_LIBRARY_PATH.
"""

import pandas as pd
import pytest

import squeezefilm as sf
from squeezefilm.cli.main import main
from squeezefilm.reynolds.device import DEVICE_ENV_VARIABLE, device_name, list_devices

POCL = "Portable Computing Language"
OTHERS = [
    name
    for name in map(device_name, list_devices())
    if "intel(r) opencl" in name.lower() and POCL not in name
]
pytestmark = pytest.mark.skipif(not OTHERS, reason="no second OpenCL (pip: intel-opencl-rt)")


def on_both(solved):
    return [solved(name) for name in (POCL, OTHERS[0])]


def test_forces_and_derivatives_agree_within_their_errors(tmp_path):
    def solved(device):
        path = tmp_path / "forces.csv"
        words = ["--h0", "4:2:10um", "--hv", "1um", "--x", "-1mm", "--outputs", "all"]
        assert main(["simulate", *words, "--device", device, "--output", str(path)]) == 0
        return pd.read_csv(path)

    one, other = on_both(solved)
    compared = 0
    for name in one.columns:
        stem, unit = name.rpartition("_")[::2]
        error = f"{stem}_error_{unit}"
        if error in one.columns and one[name].notna().all():
            assert ((one[name] - other[name]).abs() <= one[error] + other[error]).all(), name
            compared += 1
    assert compared >= 3


def test_a_study_has_the_same_model(repository, monkeypatch):
    def solved(device):
        monkeypatch.setenv(DEVICE_ENV_VARIABLE, device)
        return sf.load(repository / "config/quick.yaml").fit("limit_1").theta

    one, other = on_both(solved)
    assert [*other.values()] == pytest.approx([*one.values()], rel=1e-5)

"""Pictures of a pressure field: a sheet and an animation, the same each time; or what is wrong."""

import numpy as np
import pytest
import xarray
from PIL import Image

from squeezefilm.cli.main import main
from squeezefilm_workflow.reporting import pressure_pictures

INSTANTS, PLACES = 4, 9


@pytest.fixture
def field():
    """As `squeezefilm pressure` writes it, of an elliptical pad."""
    phase = np.linspace(0, 360, INSTANTS, endpoint=False)
    line = np.linspace(-5e-3, 5e-3, PLACES)
    x, y = np.meshgrid(line, line)
    inside = np.where(np.hypot(x, y) <= 5e-3, 1.0, np.nan)
    gap = 5e-6 * inside * (1 + 0.4 * np.sin(np.radians(phase)))[:, None, None]
    axes = ("phase", "y", "x")
    return xarray.Dataset(
        {"gauge_pressure": (axes, 1e5 * (5e-6 / gap - 1)), "gap": (axes, gap)},
        coords={"phase": phase, "y": line, "x": line},
        attrs={"h0_m": 5e-6, "hv_m": 2e-6, "frequency_hz": 43270.0},
    )


def test_a_sheet_and_an_animation_are_the_same_each_time(field, tmp_path):
    field.to_netcdf(tmp_path / "field.nc", engine="scipy")
    made = []
    for run in "ab":
        paths = [tmp_path / f"{run}{kind}" for kind in (".png", ".gif")]
        words = ["plot-pressure", str(tmp_path / "field.nc"), "--output", *map(str, paths)]
        assert main(words) == 0
        made.append([path.read_bytes() for path in paths])
    assert made[0] == made[1]
    with Image.open(tmp_path / "a.gif") as film:
        assert film.n_frames == INSTANTS


def test_the_title_has_the_position_of_a_pad_that_is_not_centred(field):
    """The axes of the pictures begin at the pad's centre, so they do not show it."""
    title = "h0 5 µm, hv 2 µm, 43.27 kHz"
    assert pressure_pictures.pressure_figure(field).get_suptitle() == title
    aside = field.assign_attrs(pad_x_m=1e-3, pad_y_m=1e-19)
    assert pressure_pictures.pressure_figure(aside).get_suptitle() == f"{title}, pad at x 1 mm"

"""The example's measured forces, config/synthetic.csv: with inertia, thermal effects and noise.

Gaps, amplitudes and forces are off by their uncertainties times normal random numbers, seed 1.
"""

import numpy as np
import pandas as pd

from squeezefilm.api.film import Film
from squeezefilm.config.loading import parse_config

OFF = {"h0 uncertainty [µm]": 0.03, "hv uncertainty [µm]": 0.01, "force uncertainty [mN]": 1.5}
H0_UM, HV_UM = np.repeat([5, 6, 7, 8], 3), np.tile([1, 1.5, 2], 4)
NEGLECTED = "inertia: none, thermal: none"
INCLUDED = "inertia: included, thermal: included, rarefaction: slip"


def synthetic_forces(text, path):
    """Return the measurements of a study, if its gas has inertia, slip and thermal effects."""
    film = Film(parse_config(text.replace(NEGLECTED, INCLUDED), path=path))
    h0_um, hv_um, force_mn = np.random.default_rng(1).normal(0, [*OFF.values()], (12, 3)).T
    points = pd.DataFrame({"h0_m": H0_UM + h0_um, "hv_m": HV_UM + hv_um}) * 1e-6
    force_mn = (1e3 * film.forces(points)["force_n"] + force_mn).round(2)
    return pd.DataFrame({"h0 [µm]": H0_UM, "hv [µm]": HV_UM, "force [mN]": force_mn, **OFF})

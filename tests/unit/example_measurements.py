"""The example's measured forces, config/synthetic.csv: computed with inertia and heat, with noise.

Gaps, amplitudes and forces are off by their uncertainties times normal random numbers.
"""

from itertools import product

import numpy as np
import pandas as pd

from squeezefilm.api.film import Film
from squeezefilm.config.loading import parse_config

SEED, GAPS_UM, AMPLITUDES_UM = 1, (5, 6, 7, 8), (1, 1.5, 2)
UNCERTAINTIES = {"h0 uncertainty [µm]": 0.03, "hv uncertainty [µm]": 0.01}
UNCERTAINTIES |= {"force uncertainty [mN]": 1.5}


def synthetic_forces(text, path):
    """Return the table of measurements of a study, of which the text is, with all of its terms."""
    film = Film(parse_config(text.replace("none", "included"), path=path))
    table = pd.DataFrame(product(GAPS_UM, AMPLITUDES_UM), columns=["h0 [µm]", "hv [µm]"])
    noise = np.random.default_rng(SEED).standard_normal((len(table), 3)) * [*UNCERTAINTIES.values()]
    points = pd.DataFrame(1e-6 * (table.to_numpy() + noise[:, :2]), columns=["h0_m", "hv_m"])
    force_mn = 1e3 * film.forces(points)["force_n"] + noise[:, 2]
    return table.assign(**{"force [mN]": force_mn.round(2)}, **UNCERTAINTIES)

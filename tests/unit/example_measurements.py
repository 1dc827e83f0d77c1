"""The example's measured forces, config/synthetic-forces.csv: computed with inertia, with noise."""

import numpy as np
import pandas as pd

from squeezefilm.api.film import Film
from squeezefilm.config.loading import Config

SEED = 1
H0_UM, HV_UM = (each.ravel() for each in np.meshgrid([5, 6, 7, 8], [1, 1.5, 2]))
UNCERTAINTIES = {"h0 [µm]": 0.03, "hv [µm]": 0.01, "force [mN]": 1.5}


def synthetic_forces(config: Config) -> pd.DataFrame:
    """Forces at gaps and amplitudes that are off by their uncertainty, and that of the force."""
    noise = np.random.default_rng(SEED).standard_normal((3, len(H0_UM)))
    off_h0, off_hv, off_force = np.array(list(UNCERTAINTIES.values()))[:, None] * noise
    gas = config["gas"] | {"inertia": "included", "heat": "included"}
    film = Film(Config(config.path, {**config.sections, "gas": gas}))
    forces = film.forces(pd.DataFrame({"h0_m": H0_UM + off_h0, "hv_m": HV_UM + off_hv}) * 1e-6)
    force_mn = (1e3 * forces["force_n"] + off_force).round(2)
    table = pd.DataFrame({"h0 [µm]": H0_UM, "hv [µm]": HV_UM, "force [mN]": force_mn})
    named = {name.replace(" [", " uncertainty ["): each for name, each in UNCERTAINTIES.items()}
    return table.assign(**named)

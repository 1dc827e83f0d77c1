"""Where in the declared space a model errs: by thirds of each factor."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.models.force_model import Factors

Array = NDArray[np.float64]

THIRDS = ("low", "middle", "high")
QUANTITIES = {
    "h0_m": "gap h0",
    "hv_m": "amplitude hv",
    "epsilon": "ratio hv/h0",
    "phi_r_m": "distance of the finger from the centre",
    "phi_deg": "direction of the finger",
    "x_m": "position of the finger along x",
    "y_m": "position of the finger along y",
}
COLUMNS = ("quantity", "third", "least", "largest", "share_of_points", "share_of_squares", "bias_n")


def regions(factors: Factors) -> Iterator[tuple[dict[str, Any], NDArray[np.bool_]]]:
    """Each third of each quantity that varies, with a mask of its points, shape (n,).

    A quantity's range is cut at its terciles over the points, which fill the space evenly.
    """
    for name in ("h0_m", "hv_m", "epsilon", *factors.position):
        values = np.asarray(getattr(factors, name), dtype=float)
        if not len(values) or np.ptp(values) == 0:
            continue
        part = np.digitize(values, np.quantile(values, [1 / 3, 2 / 3]))
        for index, third in enumerate(THIRDS):
            inside = part == index
            if inside.any():
                least, largest = float(values[inside].min()), float(values[inside].max())
                about = {"quantity": name, "third": third, "least": least, "largest": largest}
                yield about, inside


def error_by_region(factors: Factors, error_n: ArrayLike) -> pd.DataFrame:
    """Shares of the squared error in each third of each quantity.

    factors hold n points that fill the space evenly, error_n the errors there in newtons. bias_n
    is the mean error. Raises InputError where no error is known.
    """
    error = np.asarray(error_n, dtype=float)
    known = np.isfinite(error)
    squares = np.where(known, error, 0.0) ** 2
    if not squares.sum() > 0:
        raise InputError("error by region: no error is known, or all are zero")
    rows = [
        region
        | {
            "share_of_points": (inside & known).sum() / known.sum(),
            "share_of_squares": squares[inside].sum() / squares.sum(),
            "bias_n": error[inside & known].mean(),
        }
        for region, inside in regions(factors)
        if (inside & known).any()
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def in_words(table: pd.DataFrame) -> str:
    """The two quantities whose thirds hold the largest shares of the squared error."""
    ordered = table.sort_values("share_of_squares", ascending=False, kind="stable")
    return "; ".join(
        f"{worst['share_of_squares']:.0%} of the squared error lies in the {worst['third']} "
        f"third of the {QUANTITIES[worst['quantity']]}"
        for worst in ordered.drop_duplicates("quantity").head(2).to_dict("records")
    )

"""How many new points lie inside the prediction intervals of a study's models."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from scipy.stats import betabinom

from squeezefilm.api.models import Study
from squeezefilm.errors import InputError, RunError
from squeezefilm.models.prediction_interval import NORMAL, SCAN_LEVEL
from squeezefilm.studies.space import Space
from verification.comparisons import Comparison, forces_and_errors

BEYOND = 20
"""Points outside the declared space, which no interval may claim."""


def coverage(
    study: Study, models: Sequence[str], *, fresh: int, seed: int, level_of_test: float
) -> Iterator[Comparison]:
    """How many fresh points lie inside the prediction intervals of a study's models.

    Args:
        fresh: independent points, uniform over the declared space, for each model.
        seed: of their draw.
        level_of_test: probability that the number of points inside lies outside the stated
            interval, if the prediction interval is what it says.
    """
    tables: dict[bool, tuple[pd.DataFrame, np.ndarray]] = {}
    for name in models:
        try:
            fit = study.fit(name)
        except (InputError, RunError):
            continue
        interval = fit.model.interval
        if interval is None or interval.error_95 is None:
            continue
        centred = fit.model.force_model.is_centred
        if centred not in tables:
            space = Space.of(study.config, centred=centred)
            points = space.table(space.independent_sample(fresh, seed=seed))
            tables[centred] = points, forces_and_errors(study.scenes(points), study)
        points, (force_n, error_n) = tables[centred]
        try:
            stated = fit.predict_at(points)
        except InputError:
            continue  # its table of physics does not hold all over the space: it says so
        off = np.abs(stated["force_n"] - force_n) + error_n
        beyond = points.head(BEYOND).assign(h0_m=1.5 * points["h0_m"].max())
        yield Comparison(
            "predict",
            "points outside the space that have an error",
            0.0,
            0.0,
            float(fit.predict_at(beyond)["error_95_n"].notna().sum()),
            note=fit.name,
        )
        for level, quantile in NORMAL.items():
            half = stated[f"error_{100 * level:.0f}_n"].to_numpy()
            # A scan's part comes on top of what the sample measures.
            scan = interval.profile_uncertainty * quantile / NORMAL[SCAN_LEVEL]
            inside = int(np.sum(off <= half - scan * np.abs(stated["force_n"])))
            count = interval.calibration_points
            rank = int(np.ceil((count + 1) * level))
            if rank > count or np.isnan(half).all():
                continue  # such an interval is not stated
            law = betabinom(fresh, rank, count + 1 - rank)
            yield Comparison(
                "predict",
                f"points of {fresh} within {100 * level:.0f} %",
                float(law.ppf(level_of_test / 2)),
                float(law.isf(level_of_test / 2)),
                inside,
                note=f"{fit.name}, {'centred' if centred else 'all factors'}",
            )

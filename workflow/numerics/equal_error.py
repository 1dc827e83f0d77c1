"""How many times less processor time the solver takes than another method at equal error."""

import pandas as pd

from numerics.work_precision import CHOSEN, OWN

NEEDED = ("scene", "method", "path", "start", "status", "relative_error", "cpu_seconds")
COLUMNS = (
    "scene",
    "method",
    "settings",
    "relative_error",
    "cpu_seconds",
    "batch",
    "solver_settings",
    "solver_relative_error",
    "solver_estimated_error",
    "solver_cpu_seconds",
    "times_less",
)


def equal_error(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of COLUMNS: each setting of another method beside the solver at an error no larger.

    table: the rows of work_precision, all measured in one run. The solver is asked for a
    tolerance and chooses its method, its error estimate included in the time; of the tolerances
    whose true error is no larger than the other method's, the cheapest counts. Errors within the
    reference's uncertainty count as that uncertainty. Settings that the solver cannot match are
    left out.
    """
    warm = table[(table["start"] == "warm") & (table["status"] == "ok")].copy()
    warm["seen"] = warm["relative_error"].clip(lower=warm["reference_uncertainty"])
    ours = warm[(warm["method"] == CHOSEN) & (warm["path"] == "tolerance")]
    others = warm[~warm["method"].isin(OWN)]
    rows = []
    for other in others.itertuples():
        for batch, some in ours[ours["scene"] == other.scene].groupby("batch"):
            matching = some[some["seen"] <= other.seen]
            if matching.empty:
                continue
            best = matching.sort_values("cpu_seconds").iloc[0]
            rows.append(
                {
                    "scene": other.scene,
                    "method": other.method,
                    "settings": other.settings,
                    "relative_error": other.seen,
                    "cpu_seconds": other.cpu_seconds,
                    "batch": batch,
                    "solver_settings": best["settings"],
                    "solver_relative_error": best["seen"],
                    "solver_estimated_error": best["estimated_error"],
                    "solver_cpu_seconds": best["cpu_seconds"],
                    "times_less": other.cpu_seconds / best["cpu_seconds"],
                }
            )
    return pd.DataFrame(rows, columns=list(COLUMNS))

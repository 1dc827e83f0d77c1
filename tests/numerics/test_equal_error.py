"""The comparison at equal error takes the cheapest run that is at least as accurate."""

import pandas as pd

from numerics.equal_error import equal_error
from numerics.work_precision import CHOSEN


def row(method: str, error: float, seconds: float, **other: object) -> dict[str, object]:
    common = {
        "scene": "film",
        "path": "tolerance",
        "batch": 1,
        "start": "warm",
        "status": "ok",
        "settings": f"error {error:g}",
        "reference_uncertainty": 1e-12,
        "estimated_error": 2 * error,
    }
    return {**common, "method": method, "relative_error": error, "cpu_seconds": seconds, **other}


def test_the_cheapest_run_of_no_larger_error_counts():
    table = pd.DataFrame(
        [
            row(CHOSEN, 1e-3, 0.001),
            row(CHOSEN, 1e-5, 0.004),
            row(CHOSEN, 1e-7, 0.002),
            row(CHOSEN, 1e-8, 0.001, status="refused"),  # neither counts
            row(CHOSEN, 1e-8, 0.001, start="cold"),
            row("peer", 2e-5, 1.0, path="balanced"),
            row("peer", 1e-9, 9.0, path="balanced"),
            row("peer", 2e-5, 0.5, path="balanced", status="stalled"),
        ]
    )
    (found,) = equal_error(table).to_dict("records")  # nothing of ours matches 1e-9
    assert (found["relative_error"], found["solver_settings"]) == (2e-5, "error 1e-07")
    assert found["times_less"] == 500

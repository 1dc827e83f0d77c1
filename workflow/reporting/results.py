"""A finished study's results by name, each read when it is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from reporting.notes import Inertia
from squeezefilm.config.loading import STUDY_FILE, Config, load_config
from squeezefilm.errors import InputError
from squeezefilm.models.fit_file import FittedModel, number, read_fit
from squeezefilm.tables import read_columns, read_design, read_json, read_ok_forces, read_scenes

VALIDATION_NUMBERS = (
    *("points", "global_error", "sum_of_squares", "band", "share_within_band"),
    *("worst_relative_error", "worst_h0_m", "worst_hv_m"),
)


@dataclass(frozen=True)
class Results:
    """The folder of a study's results, and the study.

    Every method raises InputError naming a file that is missing or lacks what it must have.
    """

    folder: Path
    config: Config

    @classmethod
    def of(cls, folder: Path, study: Path | str | None = None) -> "Results":
        """The results in a folder, of a study's file, or else of the one that was left there."""
        return cls(folder, load_config(study or folder / STUDY_FILE))

    def forces(self, plan: str) -> pd.DataFrame:
        """The simulated forces of a plan, of which none may be missing."""
        return read_ok_forces(self.folder / f"simulations/{plan}/forces.csv")

    def scenes(self, plan: str) -> pd.DataFrame:
        """The points of a plan."""
        return read_scenes(self.folder / f"simulations/{plan}/scenes.csv")

    def fit(self, name: str) -> FittedModel:
        """A fitted model."""
        return read_fit(self.folder / f"fits/{name}.json")

    def design(self, name: str) -> pd.DataFrame:
        """A design's points."""
        return read_design(self.folder / f"designs/{name}.csv")

    def validation(self, fit: str, plan: str) -> dict[str, float]:
        """The errors of a fit on a plan, VALIDATION_NUMBERS by name."""
        path = self.folder / f"validation/{fit}_on_{plan}.json"
        summary = read_json(path)
        return {name: number(summary, name, path) for name in VALIDATION_NUMBERS}

    def errors(self, fit: str, plan: str) -> pd.DataFrame:
        """The relative error of a fit at each point of a plan."""
        file = f"validation/{fit}_on_{plan}.csv"
        return self.table(file, "h0_m", "hv_m", "relative_error")

    def table(self, file: str, *columns: str) -> pd.DataFrame:
        """Any table of the results, which has at least these columns."""
        return read_columns(self.folder / file, columns=columns)

    def summary(self, file: str) -> Mapping[str, Any]:
        """Any JSON file of the results."""
        return read_json(self.folder / file)

    def searches(self) -> Mapping[str, Any]:
        """The searches for the two-factor design: their number, and the patterns by scaling."""
        file = "designs/two_factor.json"
        summary = self.summary(file)
        for key in ("scaling", "searches", "scalings"):
            if key not in summary:
                raise InputError(f"{self.folder / file}: {key!r} is missing")
        return summary

    def row(self, table: pd.DataFrame, name: str, file: str) -> pd.Series:
        """A row by its index, of a table read from a file."""
        if name not in table.index:
            raise InputError(f"{self.folder / file}: there is no point {name!r}")
        return pd.Series(table.loc[name])

    @property
    def beyond(self) -> str:
        """Where the study's films go beyond the equation's validity; empty where they do not."""
        return Inertia.of(self.config).note(self.config["screen"]["h0_m"]["stop"])

    def exists(self, *files: str) -> bool:
        """Whether all these files are among the results."""
        return all((self.folder / file).exists() for file in files)

"""A finished study's results by name, each read when it is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from squeezefilm.config.loading import load_config
from squeezefilm.config.study import Study
from squeezefilm.config.writing import STUDY_FILE_NAME
from squeezefilm.errors import InputError, append_remedy
from squeezefilm.files import read_json
from squeezefilm.models.data import Factors, factors_of_table
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.solution import MODELLING_ERROR_COLUMNS
from squeezefilm.tables import read_columns, read_design, read_forces, read_ok_forces, read_scenes
from squeezefilm_workflow.reporting.notes import validity_note


@dataclass(frozen=True)
class Results:
    """The folder of a study's results, and the study.

    Every method raises InputError naming a file that is missing or lacks what it must have.
    """

    folder: Path
    config: Study

    @classmethod
    def of_folder(cls, folder: Path, study: Path | str | None = None) -> "Results":
        """The results in a folder, of a study's file, or else of the one that was left there."""
        if not folder.is_dir():
            known = [str(file.parent) for file in folder.parent.glob(f"*/{STUDY_FILE_NAME}")]
            there = f"; there are {', '.join(sorted(known))}" if known else ""
            raise InputError(f"{folder}: there are no such results{there}")
        return cls(folder, load_config(study or folder / STUDY_FILE_NAME))

    def forces(self, plan: str) -> pd.DataFrame:
        """The simulated forces of a plan, of which none may be missing."""
        return read_ok_forces(self.folder / f"simulations/{plan}/forces.csv")

    def simulated_points(self, plan: str) -> pd.DataFrame:
        """All points of a plan, of which some may have no force; ``status`` gives the reason."""
        return read_forces(self.folder / f"simulations/{plan}/forces.csv")

    def validation_sample(self, space: str) -> tuple[pd.DataFrame, Factors]:
        """The validation sample of a space, with points that have no force, and its factors."""
        plan = f"validation_{space}"
        forces, limits = self.simulated_points(plan), self.folder / f"simulations/{plan}/limits.csv"
        return forces, factors_of_table(forces, limits=limits)

    def scenes(self, plan: str) -> pd.DataFrame:
        """The points of a plan."""
        return read_scenes(self.folder / f"simulations/{plan}/scenes.csv")

    def fit(self, name: str) -> FittedModel:
        """A fitted model."""
        return read_fit(self.folder / f"fits/{name}.json")

    def candidate_fit_file(self, space: str, model: str) -> Path:
        """The fit of a model that is compared in a space; the study's own on all points."""
        own = "screen" if space == "two_factor" else space
        file = f"fits/{own}" if model == space else f"models/{space}/{model}"
        return self.folder / f"{file}.json"

    def design(self, name: str) -> pd.DataFrame:
        """A design's points."""
        return read_design(self.folder / f"designs/{name}.csv")

    def validation_errors(self, fit: str, plan: str) -> Mapping[str, Any]:
        """The errors of a fit on a plan."""
        return self.read_json_file(f"validation/{fit}_on_{plan}.json")

    def errors(self, fit: str, plan: str) -> pd.DataFrame:
        """The relative error of a fit at each point of a plan."""
        file = f"validation/{fit}_on_{plan}.csv"
        return self.table(file, "h0_m", "hv_m", "relative_error")

    def budget(self, plan: str, *effects: str) -> pd.DataFrame:
        """Return the neglected effects on the forces of a plan, which has at least these."""
        columns = (*MODELLING_ERROR_COLUMNS, "unknown_effects", "included_effects")
        file = f"simulations/{plan}/error_budget.csv"
        with append_remedy("run `snakemake --configfile CONFIG.yaml` again"):
            table = self.table(file, "h0_m", "hv_m", *columns, *effects)
        texts = ("unknown_effects", "included_effects")
        return table.assign(**{name: table[name].astype(object).fillna("") for name in texts})

    def table(self, file: str, *columns: str) -> pd.DataFrame:
        """Any table of the results, which has at least these columns."""
        return read_columns(self.folder / file, columns=columns)

    def read_json_file(self, file: str) -> Mapping[str, Any]:
        """Any JSON file of the results."""
        return read_json(self.folder / file)

    def row(self, table: pd.DataFrame, name: str, file: str) -> pd.Series:
        """A row by its index, of a table read from a file."""
        if name not in table.index:
            raise InputError(f"{self.folder / file}: there is no point {name!r}")
        return pd.Series(table.loc[name])

    @property
    def validity_note(self) -> str:
        """Return a note on films outside the equation's validity range; empty where they do not."""
        return validity_note(self.config)

    def has_file(self, file: str) -> bool:
        """Return whether a file is among the results."""
        return (self.folder / file).exists()

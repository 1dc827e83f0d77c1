"""A study: a film with the ranges that its experiments span, and models fitted to them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from squeezefilm.api.film import Film
from squeezefilm.api.fit import Fit
from squeezefilm.config.loading import Config, load_config
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.validity import OK
from squeezefilm.models.force_model import get_model
from squeezefilm.reynolds import solve
from squeezefilm.studies.plans import four_factor_plan, level_grid
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.studies.space import Space, finger_positions
from squeezefilm.studies.study import scenes_in, surface_of
from squeezefilm.studies.tasks.fits import fit_to_forces, limit_table_values


@dataclass(frozen=True, repr=False)
class Study(Film):
    """A film as a study's file describes it, with the study's ranges and models.

    Attributes:
        config: the whole study.
    """

    config: Config

    @property
    def name(self) -> str:
        """The study's name, which its results bear."""
        return str(self.config["study"])

    def plan(self, *, centred: bool) -> pd.DataFrame:
        """The points that models are fitted to: the study's screen, and all its positions.

        Every gap of the screen with every amplitude, the finger at the centre or at each of the
        study's positions too: h0_m, hv_m, and the position in the surface's form, phi_r_m and
        phi_deg or x_m and y_m.
        """
        return four_factor_plan(
            level_grid(self.config["screen"]),
            positions=[(0.0, 0.0)] if centred else finger_positions(self.config),
            position=surface_of(self.config).position,
        )

    def fit(self, model: str, *, seeds: int = 1, processes: int = 1) -> Fit:
        """Simulate the study's plan, fit a model to the forces and validate it.

        A model of gap and amplitude alone is fitted to the screen, the finger centred; any other to
        the screen at every position of the study. Its prediction interval comes from the study's
        validation sample, which is simulated too.

        Args:
            model: the library's, such as ``two_factor`` or ``limit_1``, or one of the study's own.
            seeds: of the search, each with every bound of the study; a model that is linear in its
                parameters needs none.
            processes: to spread the searches over.

        Raises InputError for an unknown model or one that cannot be fitted to these points,
        RunError for a point that has no force.
        """
        if seeds < 1:
            raise InputError(f"seeds: {seeds} must be 1 or more")
        config = self.config
        chosen = get_model(model, config["models"], place=config.path)
        forces, sample = self._simulated(centred=chosen.is_centred)
        for failed in forces[forces["status"] != OK].itertuples():
            raise RunError(f"point {failed.point_id}: {failed.status}")
        fitted, _ = fit_to_forces(
            chosen,
            config,
            forces=forces,
            sample=sample,
            limit_table=self._limit_table if chosen.column_names else None,
            seeds=seeds,
            processes=processes,
            source={"study": self.name},
        )
        return Fit(fitted)

    def _simulated(self, *, centred: bool) -> tuple[pd.DataFrame, pd.DataFrame]:
        """The plan and the validation sample with their forces; simulated once for all models."""
        if centred not in self._simulations:
            drawn, space = self.config["validation"], Space.of(self.config, centred=centred)
            sample = space.table(space.independent_sample(drawn["points"], seed=drawn["seed"]))
            self._simulations[centred] = (
                self._solved(self.plan(centred=centred)),
                self._solved(sample),
            )
        return self._simulations[centred]

    @cached_property
    def _limit_table(self) -> dict[str, Any]:
        return limit_table_values(self.config)

    @cached_property
    def _simulations(self) -> dict[bool, tuple[pd.DataFrame, pd.DataFrame]]:
        return {}

    def _solved(self, points: pd.DataFrame) -> pd.DataFrame:
        """The points with their forces."""
        settings, device = solver_settings(self.config, outputs=()), self.device
        scenes = settings.resolved(scenes_in(points, self.config), device)
        found = solve(scenes, **settings.how(device)).to_frame(points.index)
        return points.assign(**found[["force_n", "force_error_n", "status", "left_out"]])


def load(path: Path | str) -> Study:
    """The study that a configuration file describes.

    Raises InputError naming the file, the key, what is wrong with it and what is allowed.
    """
    return Study(load_config(path))

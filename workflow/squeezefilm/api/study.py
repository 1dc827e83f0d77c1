"""A study: a film with the ranges that its experiments span, and models fitted to them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from squeezefilm import __version__
from squeezefilm.api.film import Film
from squeezefilm.api.fit import Fit
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.positions import as_in
from squeezefilm.io.tables import FACTOR_COLUMNS, scene_points
from squeezefilm.models.fitted import expected_error, fit_of
from squeezefilm.models.fitting.described import described_fit
from squeezefilm.models.force_model import COLUMNS, Factors
from squeezefilm.models.library import model_named
from squeezefilm.reynolds import solve
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.plans import finger_positions, four_factor_plan, level_values
from squeezefilm.studies.study import scene_of, surface_of, symmetry_of
from squeezefilm.studies.tasks.physics_limits import limit_table_of, with_limits
from squeezefilm.studies.tasks.scan_errors import DRAWS, SEED, errors_in_study


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
        levels = (level_values(self.config["screen"][name]) for name in FACTOR_COLUMNS[:2])
        gaps, amplitudes = np.meshgrid(*levels, indexing="ij")
        return four_factor_plan(
            positions=[(0.0, 0.0)] if centred else finger_positions(self.config),
            h0_m=gaps.ravel(),
            hv_m=amplitudes.ravel(),
            position=surface_of(self.config).position,
        )

    def fit(self, model: str, *, seeds: int = 1, processes: int = 1) -> Fit:
        """Simulate the study's plan and fit a model to the forces.

        A model of gap and amplitude alone is fitted to the screen, the finger centred; any other to
        the screen at every position of the study.

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
        chosen = model_named(model, config["models"], place=config.path)
        points = self.plan(centred=chosen.is_centred)
        scenes = [scene_of(point, config) for point in scene_points(points)]
        settings = self._settings(None, None)
        solutions = solve(
            scenes,
            tolerance=settings.tolerance,
            model_tolerance=settings.model_tolerance,
            method=settings.method,
            device=self.device,
        )
        for scene, solution in zip(scenes, solutions, strict=True):
            if solution.status != "ok":
                raise RunError(f"point {scene.point_id}: {solution.status}")
        columns: dict[str, np.ndarray] = {}
        if chosen.column_names:
            limits = with_limits(points, scenes)
            columns = {name: limits[name].to_numpy() for name in COLUMNS.values()}
        factors = {name: points[name].to_numpy() for name in as_in(FACTOR_COLUMNS, points)}
        found, _ = described_fit(
            chosen,
            Factors.of(**factors, **columns),
            np.array([solution.force_n for solution in solutions]),
            force_error_n=np.array([solution.force_error_n for solution in solutions]),
            settings=config["fit"] | {"seeds": dict.fromkeys(config["fit"]["seeds"], seeds)},
            scan_error=self._scan_error(),
            processes=processes,
        )
        found["directions"] = symmetry_of(config).to_dict()
        if chosen.column_names:
            found["limit_table"] = limit_table_of(config).to_dict()
        found["source"] = {"squeezefilm": __version__, "study": self.name}
        fitted = fit_of(found, place=f"{self.name}: {chosen.name}")
        return Fit(fitted, expected_error(fitted, None))

    def _scan_error(self) -> float:
        """The largest share of a force that the scan leaves open, 0 without one."""
        scan = self.scan
        if scan is None:
            return 0.0
        errors = errors_in_study(self.config, scan, draws=DRAWS, seed=SEED)
        return float(errors["scan_error_share"].max())


def load(path: Path | str) -> Study:
    """The study that a configuration file describes.

    Raises InputError naming the file, the key, what is wrong with it and what is allowed.
    """
    return Study(load_config(path))

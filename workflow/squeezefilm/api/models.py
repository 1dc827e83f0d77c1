"""A fitted model, and a study whose models are fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from squeezefilm.api.film import (
    FactorValues,
    Film,
    Position,
    parse_factor_values,
    points_of_factors,
)
from squeezefilm.config import study
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError, RunError, prefix_errors
from squeezefilm.files import write_json
from squeezefilm.formatting import result_lines_text
from squeezefilm.lazy import pd
from squeezefilm.tables import FACTOR_COLUMNS, failed_point_texts, normalise_points

if TYPE_CHECKING:
    from squeezefilm.models.fit_file import FittedModel

DEFAULT_GAP_COUNT = 6
"""Evenly spaced over the range of the fit, where no gap is given."""


@dataclass(frozen=True)
class Fit:
    """A force model with its parameters and the prediction interval of a validation sample.

    Attributes:
        model: contents of its file.
    """

    model: FittedModel

    @classmethod
    def read(cls, path: Path | str) -> Fit:
        """The fit in a file that ``squeezefilm fit`` or ``save`` wrote.

        Raises InputError naming the file, for one that cannot be read or is none.

        Example:
            >>> Fit.read("limit_1.json").name
        """
        from squeezefilm.models.fit_file import read_fit

        return cls(read_fit(path))

    @property
    def statement(self) -> str:
        """A sentence about the model's error.

        Example:
            >>> fit.statement
        """
        return self.model.statement

    @property
    def name(self) -> str:
        """The model's name."""
        return self.model.model

    @property
    def about(self) -> dict[str, str]:
        """The model's name and the statement of its error, as a row."""
        return {"model": self.name, "validation": self.statement}

    @property
    def theta(self) -> dict[str, float]:
        """The parameters by name, in the units of ``model.force_model.parameter_units``.

        Example:
            >>> fit.theta
        """
        return dict(zip(self.model.force_model.parameter_names, self.model.theta, strict=True))

    def predict(
        self, h0: FactorValues, hv: FactorValues, **position: Unpack[Position]
    ) -> pd.DataFrame:
        """The model's forces at every combination of gaps, amplitudes and positions.

        The columns are those of ``predict_at``.
        Raises InputError as ``Film.curve`` does.

        Example:
            >>> fit.predict(h0="6 um", hv="0.5:2:4 um")[["hv_m", "force_n", "error_95_n"]]
        """
        return self.predict_at(points_of_factors(h0=h0, hv=hv, **position))

    def predict_at(self, points: pd.DataFrame, *, source: object = "predict") -> pd.DataFrame:
        """The model's forces at a table of points: h0_m, hv_m and a position, if any.

        ``error_95_n`` and ``error_99_n`` are the half widths of the prediction interval
        (``statement`` says what it is); empty where a point is not validated, and ``note`` says
        why. ``validity`` is ``ok``, or the limits of validity of the film equation that the point's
        film exceeds, or why there is no film, and then no force.
        Raises InputError that begins with ``source``, for values without physical meaning.

        Example:
            >>> fit.predict_at(pd.DataFrame({"h0_m": [6e-6], "hv_m": [1e-6]}))["force_n"]
        """
        from squeezefilm.models.data import factors_of_table

        fit = self.model
        with prefix_errors(source):
            points = _points_with_factor_columns(points, needed=FACTOR_COLUMNS[:2])
            given = factors_of_table(points)
        factors, has_film = fit.folded_factors(given), [not t for t in fit.no_film_texts(given)]
        force_n = np.where(has_film, fit.evaluate(factors), np.nan)
        error_95_n, error_99_n, notes = fit.validation(factors, force_n)
        return points.assign(
            force_n=force_n,
            error_95_n=error_95_n,
            error_99_n=error_99_n,
            **fit.error_percent_columns(error_95_n, force_n),
            validity=fit.validity(given),
            note=np.where(has_film, notes, ""),
        )

    def amplitude_for(
        self, force: str | float, h0: FactorValues | None = None, **position: Unpack[Position]
    ) -> pd.DataFrame:
        """The smallest amplitude that gives a force, a row for each gap and position.

        Args:
            force: target, in newtons or with its unit.
            h0: gaps; evenly spaced over the range of the fit by default.

        ``hv_error_95_m`` is the 95 % error of the force over its slope, ``error_95_percent`` that
        of the force; empty where the point is not validated, and ``note`` says why.
        Raises InputError as ``predict`` does.

        Example:
            >>> fit.amplitude_for("0.2 N", h0="5 um")[["hv_m", "hv_error_95_m"]]
        """
        points = points_of_factors(h0=self.gaps() if h0 is None else h0, **position)
        return self.amplitudes_for(points, force)

    def amplitudes_for(self, points: pd.DataFrame, force: str | float) -> pd.DataFrame:
        """The smallest amplitudes for a force at a table of points: h0_m and a position, if any.

        Example:
            >>> fit.amplitudes_for(pd.DataFrame({"h0_m": [5e-6, 6e-6]}), "0.2 N")["hv_m"]
        """
        from squeezefilm.models.data import factors_of_table
        from squeezefilm.models.fit_file import amplitude_row

        forces_n = parse_factor_values(force, called="force", unit="N")
        if len(forces_n) != 1:
            raise InputError(f"force: {force!r} are several; one is asked for")
        with prefix_errors("amplitude-for"):
            points = _points_with_factor_columns(points, needed=FACTOR_COLUMNS[:1])
            factors = factors_of_table(points.assign(hv_m=0.0))
        rows = [
            amplitude_row(self.model, factors.take([index]), force_n=forces_n[0])
            for index in range(len(factors))
        ]
        return pd.concat([points, pd.DataFrame(rows)], axis=1)

    def gaps(self) -> list[float]:
        """A few gaps in metres, evenly spaced over those of the fit.

        Raises InputError where the fit has none.

        Example:
            >>> fit.gaps()
        """
        ranges = self.model.ranges
        if "h0_m" not in ranges:
            raise InputError(f"{self.model.file}: tells no range of gaps; give them")
        low, high = ranges["h0_m"]
        gaps = np.linspace(low, high, DEFAULT_GAP_COUNT if high > low else 1)
        return [float(f"{gap:.12g}") for gap in gaps]

    def code(self, language: str, *, name: str = "") -> str:
        """The model as code without dependencies, in C, Python, JavaScript or MATLAB.

        Args:
            language: ``c``, ``python``, ``javascript`` or ``matlab``.
            name: of the function in MATLAB, which is that of its file; by default the model's.

        Raises InputError for a model with asymptotic forces whose file has no table of them.

        Example:
            >>> print(fit.code("c"))
        """
        from squeezefilm.models.export import source_code

        return source_code(self.model, language, name=name)

    def save(self, path: Path | str) -> None:
        """Write the fit's file, which ``Fit.read`` and the command line read.

        Example:
            >>> fit.save("limit_1.json")
        """
        write_json(self.model.to_dict(), path)

    def __str__(self) -> str:
        fit = self.model
        units = dict(zip(self.theta, fit.force_model.parameter_units, strict=True))
        theta = {name: f"{value:.6g}" for name, value in self.theta.items()}
        theta |= {name: f"{theta[name]} {units[name]}" for name in theta if units[name] != "1"}
        for known in fit.parameter_ranges:
            low, high = (known[end] for end in ("lower", "upper"))
            ends = ["open" if end is None else f"{end:.4g}" for end in (low, high)]
            theta[known["name"]] += f", 95 % range {ends[0]} to {ends[1]}"
        theta |= {"parameters": "; ".join(fit.parameter_notes)} if fit.parameter_notes else {}
        formula = f"{self.name}: {fit.force_model.formula_text}"
        row = {"formula": formula, **theta, "fitted_points": fit.points}
        row |= {"global_error": fit.global_error, "validation": self.statement}
        if fit.prediction_interval:
            row |= {"prediction error (95 %)": fit.prediction_interval.error_95_text}
        return result_lines_text(row)

    __repr__ = __str__


def _points_with_factor_columns(points: pd.DataFrame, *, needed: Sequence[str]) -> pd.DataFrame:
    """Points with the factors under their own names."""
    from squeezefilm.api.points import Points

    return Points(normalise_points(points, needed=needed))


@dataclass(frozen=True, repr=False)
class Study(Film):
    """A film as a study's file describes it, with the study's ranges and models.

    Attributes:
        config: the whole study.
    """

    config: study.Study

    @property
    def name(self) -> str:
        """The study's name, which its results bear."""
        return self.config.study

    def plan(self, *, centred: bool) -> pd.DataFrame:
        """The points that models are fitted to: the study's screen, and all its positions.

        Every gap of the screen with every amplitude, the pad at the centre or at each of the
        study's positions too: h0_m, hv_m, and the position in the surface's form, phi_r_m and
        phi_deg or x_m and y_m.

        Example:
            >>> len(study.plan(centred=True))
        """
        from squeezefilm.studies.plans import plan_scenes_table

        screen = plan_scenes_table("screen", self.config)
        return screen if centred else plan_scenes_table("four_factor", self.config, design=screen)

    def fit(self, model: str, *, seeds: int = 1, processes: int = 1) -> Fit:
        """Simulate the study's plan, fit a model to the forces and validate it.

        A model of gap and amplitude alone is fitted to the screen, the pad centred; any other to
        the screen at every position of the study. Its prediction interval comes from the study's
        validation sample, which is simulated too.

        Args:
            model: the library's, such as ``two_factor`` or ``limit_1``, or one of the study's own.
            seeds: of the search, each with every bound of the study; a model that is linear in its
                parameters needs none.
            processes: to spread the searches over.

        Raises InputError for an unknown model or one that cannot be fitted to these points,
        RunError for a point that has no force.

        Example:
            >>> fit = study.fit("limit_1")
            >>> print(fit)
        """
        from squeezefilm.models.force_model import get_model
        from squeezefilm.studies.tasks.fits import fit_to_forces

        if seeds < 1:
            raise InputError(f"seeds: {seeds} must be 1 or more")
        config = self.config
        chosen = get_model(model, config.models, source=config.path)
        forces, sample = self._plan_and_sample_forces(centred=chosen.is_for_centred_pad)
        for failure in failed_point_texts(forces):
            raise RunError(failure)
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

    def _plan_and_sample_forces(self, *, centred: bool) -> tuple[pd.DataFrame, pd.DataFrame]:
        """The plan and the validation sample with their forces; simulated once for all models."""
        from squeezefilm.studies.plans import VALIDATION_SAMPLE_PLANS, plan_scenes_table

        if centred not in self._forces_cache:
            sample = plan_scenes_table(VALIDATION_SAMPLE_PLANS[0 if centred else 1], self.config)
            points = self.plan(centred=centred)
            self._forces_cache[centred] = (
                self._points_with_forces(points),
                self._points_with_forces(sample),
            )
        return self._forces_cache[centred]

    @cached_property
    def _limit_table(self) -> dict[str, Any]:
        from squeezefilm.studies.tasks.fits import limit_table_values

        return limit_table_values(self.config)

    @cached_property
    def _forces_cache(self) -> dict[bool, tuple[pd.DataFrame, pd.DataFrame]]:
        return {}

    def _points_with_forces(self, points: pd.DataFrame) -> pd.DataFrame:
        """The points with their forces."""
        forces = self.solver(outputs=()).solve(self.scenes(points)).to_frame(points.index)
        return points.assign(**forces[["force_n", "force_error_n", "status", "absent_terms"]])


def load(path: Path | str) -> Study:
    """The study that a configuration file describes; ``Film.read`` reads a film alone.

    Raises InputError naming the file, the key, what is wrong with it and what is allowed.

    Example:
        >>> study = sf.load("config/paper.yaml")
    """
    return Study(load_config(path))

"""A fit beside the validation sample of its study."""

from __future__ import annotations

import argparse
from typing import Any

from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_forces
from squeezefilm.models.data import factors_of
from squeezefilm.models.fit_file import fit_of
from squeezefilm.studies.plans import declared_ranges


def add_sample_options(parser: argparse.ArgumentParser) -> None:
    """The options of a validation sample."""
    parser.add_argument("--sample", metavar="FORCES.csv", help="forces of a validation sample")
    parser.add_argument(
        "--sample-limits", metavar="LIMITS.csv", help="physics limits of its scenes"
    )


def with_validation(
    about: dict[str, Any], config: Config, *, sample: str | None, sample_limits: str | None
) -> dict[str, Any]:
    """What a fit's file holds, with the prediction interval that a sample gives, if there is one.

    Args:
        sample, sample_limits: tables of its forces and of their physics limits.
    """
    if not sample:
        return about
    forces = read_forces(sample)
    factors = factors_of(forces, limits=sample_limits)
    fit = fit_of(about, place=sample).validated(
        factors,
        force_n=forces["force_n"].where(forces["status"] == "ok"),
        force_error_n=forces["force_error_n"],
        ranges=declared_ranges(config, centred=not factors.phi_r_m.any()),
    )
    print(fit.statement)
    return fit.to_dict()

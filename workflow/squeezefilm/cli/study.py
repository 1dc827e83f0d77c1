"""Commands for a study of one's own: its scan, its fits, their errors, and designs."""

import argparse
import sys
from pathlib import Path

from squeezefilm.cli.options import (
    FIT_ARGUMENT,
    FORCES_ARGUMENT,
    STUDY_OPTION,
    command,
    option,
    print_notes,
    print_table,
    result_text,
    table_output_option,
)
from squeezefilm.config.film import FilmSections
from squeezefilm.config.loading import FilmWithoutStudyError, load_config, load_film
from squeezefilm.config.notes import unit_notes
from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.files import file_digest, write_json
from squeezefilm.studies.tasks.scan_errors import scan_report
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_forces, read_ok_forces, read_scenes


@command(
    STUDY_OPTION,
    option("--forces", "FORCES.csv", "forces with other noise"),
    option("--table", "PROFILE.csv", "the scan's points and residuals"),
)
def profile(options: argparse.Namespace) -> None:
    """Fit a smooth profile to a scan, show its residuals and what its noise does to forces.

      squeezefilm profile --config config/mine.yaml [--forces FORCES.csv] [--table PROFILE.csv]

    The profile is the one that every simulation of the study uses. Its noise is drawn again, from
    the residuals, and some of the study's scenes are simulated with each profile that comes out.
    FORCES.csv has their forces with the half of the interval that holds the noise's part in 95 % of
    all scans (`measurement_noise_n`), its change by modes that the points do not determine
    (`misfit_n`), the force missing for a neglected quadrature component (`quadrature_n`), and the
    sum of all (`scan_error_n`), without the solver's error. A film without a study has no such
    forces.

    PROFILE.csv has the scan's points with their residuals;
    `squeezefilm plot profile PROFILE.csv --output profile.png` draws them.
    """
    config: FilmSections
    try:
        config = load_config(options.config)
    except FilmWithoutStudyError as film_alone:
        if options.forces:
            raise InputError(f"--forces: {film_alone}") from None
        config = load_film(options.config)
    print_notes(unit_notes(config))
    forces, table, _, text = scan_report(config)
    if options.forces:
        write_table(forces, options.forces)
    if options.table:
        write_table(table, options.table)
    print(text)


@command(
    FORCES_ARGUMENT,
    option("--model", "NAME", "such as two_factor", required=True),
    STUDY_OPTION,
    option("--output", "FIT.json", "the best run", required=True),
    option("--sample", "FORCES.csv", "forces of a validation sample"),
    option("--runs", "RUNS.csv", "all runs"),
    option("--seeds", help="instead of the study's number of seeds", type=int),
    option("--processes", help="to spread the runs over", type=int, default=1),
)
def fit(options: argparse.Namespace) -> None:
    """Fit an empirical force model to simulated forces, from many random starts.

      squeezefilm fit FORCES.csv --model two_factor --config C.yaml --output FIT.json \\
          [--runs RUNS.csv]

    The model is one of the library's or of the study's own (its section `models`). What a model
    uses of the asymptotic forces is computed for the points, and a table over the study's space put
    into FIT.json. Where the study's profile is measured, the uncertainty by its noise is part
    of the fit's error. --sample has the forces of a validation sample, such as those of the study's
    plans validation_two_factor and validation_four_factor: without one the fit is not validated at
    any point.

    A model of gap and amplitude alone is fitted with the study's `two_factor` seeds, one that knows
    the pad's position with its `four_factor` seeds. Each of the study's bounds and seeds gives one
    run of the paper's method, a genetic algorithm followed by Nelder-Mead; one run per bound of
    SciPy's differential evolution checks them. A run with wider bounds checks `fit.bounds`: where
    it is much better it is taken, and a note of the fit states so.

    A model that is linear in its parameters is solved at once. RUNS.csv has every run, FIT.json the
    run with the least sum of squares and all that is needed to use the model: formula, parameters
    and their units and profile-likelihood ranges, ranges of the factors, errors on the points and
    on held-out points, and the prediction interval that the sample gives (`squeezefilm predict`).
    """
    from squeezefilm.api.models import Fit
    from squeezefilm.models.force_model import get_model
    from squeezefilm.studies.tasks.fits import fit_to_forces, profile_uncertainty_fraction

    config = load_config(options.config)
    model = get_model(options.model, config.models, source=options.config)
    forces = read_ok_forces(options.forces)
    sample = read_forces(options.sample) if options.sample else None
    uncertainty = profile_uncertainty_fraction(config)
    with prefix_errors(options.forces):
        fitted, runs = fit_to_forces(
            model,
            config,
            forces=forces,
            sample=sample,
            uncertainty=uncertainty,
            seeds=options.seeds,
            processes=options.processes,
            source={"forces_sha256": file_digest(Path(options.forces))},
        )
    if options.runs:
        write_table(runs, options.runs)
    write_json(fitted.to_dict(), options.output)
    print(Fit(fitted))


@command(
    FIT_ARGUMENT,
    FORCES_ARGUMENT,
    STUDY_OPTION,
    table_output_option("--output", "ERRORS.csv", "error of each point", required=True),
)
def validate(options: argparse.Namespace) -> None:
    """Compare a fitted model with simulated forces: errors point by point, and their summary.

    squeezefilm validate FIT.json FORCES.csv --config C.yaml --output ERRORS.csv
    """
    from squeezefilm.models.fit_file import read_fit
    from squeezefilm.studies.tasks.fits import errors_of_fit

    config = load_config(options.config)
    fitted, forces = read_fit(options.fit), read_ok_forces(options.forces)
    with prefix_errors(f"{options.fit} on {options.forces}"):
        table, summary = errors_of_fit(fitted, forces, config)
    write_table(table, options.output)
    print(result_text(summary, options))


@command(
    FIT_ARGUMENT,
    option("--forces", "FORCES.csv", "what it was fitted to", required=True),
    STUDY_OPTION,
    option("--existing", "SCENES.csv", "points to add to"),
    table_output_option("--output", "DESIGNS.csv", "designs to write", required=True),
)
def optimal(options: argparse.Namespace) -> None:
    """D-optimal designs with a bound of their efficiency, for a fitted model.

      squeezefilm optimal FIT.json --forces FORCES.csv --config C.yaml --output DESIGNS.csv \\
          [--existing SCENES.csv]

    The model is FIT.json's, FORCES.csv what it was fitted to: they give the parameters, and how far
    these can go; the study's ranges are the box in which points may lie. DESIGNS.csv has these
    designs, the first three with a bound of their efficiency by the equivalence theorem (between
    candidates by sampled maxima):

      local      the best weights of points anywhere in the space, for the fitted parameters; on a
                 grid for a formula that jumps or has forces of the asymptotic expansion
      bayesian   for the mean over the parameter vectors at the ends of the parameters' ranges
      maximin    for the worst of these vectors
      exact-N    the best N points found by exchange from 50 starts, each once and apart from the
                 others
      augmented  the points of --existing and the best ones found to add to them

    Their D-efficiencies are printed, with a lower bound that does not need the best design. With
    --existing points outside the ranges that of `augmented` can exceed 1.
    """
    from squeezefilm.models.fit_file import read_fit
    from squeezefilm.studies.tasks.optimal_designs import designs_of_fit

    fitted, forces = read_fit(options.fit), read_ok_forces(options.forces)
    config = load_config(options.config)
    with prefix_errors(options.fit):
        tables = designs_of_fit(
            fitted,
            config,
            forces=forces,
            existing=read_scenes(options.existing) if options.existing else None,
        )
    write_table(tables["designs"], options.output)
    for note in tables["summary"]["notes"]:
        print(f"note: {note}", file=sys.stderr)
    print_table(tables["efficiencies"][["plan", "points", "d_efficiency", "d_efficiency_lower"]])

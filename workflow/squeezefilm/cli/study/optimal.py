"""D-optimal designs with a certificate, for a fitted model and points of one's own.

  squeezefilm optimal FIT.json --forces FORCES.csv --config C.yaml --output DESIGNS.csv \\
      [--existing SCENES.csv]

The model is FIT.json's, FORCES.csv what it was fitted to: they give the parameters, and how far
these can go; the study's ranges are the box in which points may lie. DESIGNS.csv has these designs,
all certified by the equivalence theorem:

  local      the best weights of points anywhere in the space, for the fitted parameters
  bayesian   for the mean over the parameter vectors at the ends of the parameters' ranges
  maximin    for the worst of these vectors
  exact-N    the best N points, each once and apart from the others
  augmented  the points of --existing and the best ones to add to them

Their D-efficiencies are printed, with a lower bound that does not need the best design.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.errors import naming
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.fits import limits_for
from squeezefilm.studies.tasks.optimal_designs import designs_of_fit
from squeezefilm.tables import read_ok_forces, read_scenes, write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument(
        "--forces", required=True, metavar="FORCES.csv", help="what it was fitted to"
    )
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--existing", metavar="SCENES.csv", help="points to add to")
    parser.add_argument("--output", required=True, metavar="DESIGNS.csv", help="designs to write")


def run(options: argparse.Namespace) -> None:
    fit, forces = read_fit(options.fit), read_ok_forces(options.forces)
    config = load_config(options.config)
    with naming(options.fit):
        designs, efficiencies, *_ = designs_of_fit(
            fit,
            config,
            forces=forces,
            limits=limits_for(fit.force_model, forces, config),
            existing=read_scenes(options.existing) if options.existing else None,
        )
    write_table(designs, options.output)
    shown = efficiencies[["plan", "points", "d_efficiency", "lower_bound"]]
    print(shown.to_string(index=False))

"""Write a fitted model as code without dependencies, for firmware and for notebooks.

  squeezefilm export FIT.json --language c --output force.h
  squeezefilm export FIT.json --language python --output force.py
  squeezefilm export FIT.json --language javascript --output force.js

The C header (C99, <math.h>) has NAME_force_n(h0_m, hv_m, …), the Python module force_n(h0_m, hv_m,
…), JavaScript a constant NAME with NAME.force_n(h0_m, hv_m, …), all in newtons from SI units
(phi_deg in degrees), with a function for the 95 % error of a force and one that says whether a
point lies in the declared space (see `squeezefilm predict --help`). A model that uses the physics
limit is written with its table of it, whose error is stated; without a table, where the limit does
not hold all over the study's space, a model cannot be exported.
"""

import argparse

from squeezefilm.api.fit import Fit
from squeezefilm.files import write_text
from squeezefilm.models.export import LANGUAGES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--language", required=True, choices=LANGUAGES)
    parser.add_argument("--output", metavar="FILE", help="file to write, else it is shown")


def run(options: argparse.Namespace) -> None:
    text = Fit.read(options.fit).code(options.language)
    if options.output:
        write_text(text, options.output)
    else:
        print(text, end="")

"""The pressure under a finger over one period, as a file.

  squeezefilm pressure --h0 5um --hv 2.2um --output field.csv
  squeezefilm pressure --h0 5um --hv 2.2um --x 1mm --output field.nc --config CONFIG.yaml

A CSV table has a row for each instant and place: phase_deg, time_s, x_m, y_m (from the finger's
centre, along its own axes), overpressure_pa, gap_m. A name that ends in .nc makes a NetCDF file,
with units and what was solved among its attributes. Both need xarray: the extra `fields`.
"""

import argparse

from squeezefilm.api.field import LEAST_INSTANTS, LEAST_PLACES, MOST_INSTANTS, MOST_PLACES
from squeezefilm.cli.options import POINTS, add_options, add_point_options, film_at
from squeezefilm.errors import InputError
from squeezefilm.files import whole_file
from squeezefilm.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_options(parser, "config")
    parser.add_argument("--output", required=True, metavar="FIELD", help=".csv or .nc, to write")
    parser.add_argument(
        "--places", type=int, default=41, help=f"each way, {LEAST_PLACES} to {MOST_PLACES}"
    )
    parser.add_argument(
        "--instants", type=int, default=32, help=f"even, {LEAST_INSTANTS} to {MOST_INSTANTS}"
    )
    add_point_options(parser, many=False)


def run(options: argparse.Namespace) -> None:
    if not options.output.endswith((".csv", ".nc")):
        raise InputError(f"--output {options.output}: name a file that ends in .csv or .nc")
    given = {name: getattr(options, name) for name in POINTS}
    if not (given["h0"] and given["hv"]):
        raise InputError("give --h0 and --hv")
    film = film_at(options.config)
    field = film.pressure(**given, places=options.places, instants=options.instants)
    if options.output.endswith(".nc"):
        with whole_file(options.output) as path:
            field.to_netcdf(path, engine="scipy")
        return
    table = field.to_dataframe().reset_index().dropna()
    table["phase_deg"] = table.pop("phase")
    names = {"time": "time_s", "x": "x_m", "y": "y_m", "overpressure": "overpressure_pa"}
    table = table.rename(columns={**names, "gap": "gap_m"})
    columns = ["phase_deg", *names.values(), "gap_m"]
    write_table(table[columns], options.output)

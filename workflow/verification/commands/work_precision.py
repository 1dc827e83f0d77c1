"""Error against run time of the solver and of three other methods, as a table.

  squeezefilm work-precision FIT.json --config CONFIG.yaml --output TABLE.csv

Errors are those of the mean force against a reference that shares nothing with any method; run
times are medians of repeats, processor time of all threads. FIT.json is the fitted
empirical model whose own error is noted beside, for it tells where a solver's error no longer
matters. Times need a quiet machine, and BLAS with a single thread (OPENBLAS_NUM_THREADS=1).
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.tables import write_table
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.solver_settings import device_of
from verification.work_precision import FILMS, work_precision

SAMPLE = (FILMS[1],)
BATCH = 100
RUNGS = {"full": 10, "sample": 3}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted empirical model")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    settings = config["numerics"]
    device = device_of(config)
    table = work_precision(
        FILMS if settings["extent"] == "full" else SAMPLE,
        repeats=settings["repeats"],
        batch=BATCH,
        longest_seconds=settings["longest_seconds"],
        rungs=RUNGS[settings["extent"]],
        device=device,
    )
    note = (
        f"Centred sinc; off centre: by 2.9 mm. Warm, median of {settings['repeats']}; processor "
        f"time of all threads; {device.name}; a batch has {BATCH} films."
    )
    model_error = read_fit(options.fit).global_error
    write_table(table.assign(model_error=model_error, note=note), options.output)

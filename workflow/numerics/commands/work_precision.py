"""Error against run time of the solver and of other people's methods, as a table.

  squeezefilm work-precision FIT.json --config CONFIG.yaml --output TABLE.csv

Errors are those of the mean force against a reference that shares nothing with any method, of films
with inertia against the solver's own force to 1e-8; run times are medians of repeats, processor
time of all threads and wall time. FIT.json is the fitted empirical model whose own error is noted
beside, for it tells where a solver's error no longer matters. Times need a quiet machine, and BLAS
with a single thread (OPENBLAS_NUM_THREADS=1).
"""

import argparse

import pandas as pd

from numerics.peers import freefem
from numerics.work_precision import FILMS, cold_starts, work_precision
from squeezefilm.io.tables import write_table
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of

SAMPLE = (FILMS[4],)
BATCH = 100
RUNGS = {"full": 10, "sample": 3}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted empirical model")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    settings = config["numerics"]
    full = settings["extent"] == "full"
    device = device_of(config)
    model_error = read_fit(options.fit).global_error
    warm = work_precision(
        FILMS if full else SAMPLE,
        repeats=settings["repeats"],
        batch=BATCH,
        longest_seconds=settings["longest_seconds"],
        rungs=RUNGS[settings["extent"]],
        model_error=model_error,
        device=device,
    )
    cold = cold_starts(device=device, compiling=full).assign(model_error=model_error)
    table = pd.concat([warm, cold], ignore_index=True)
    write_table(table.assign(note=_note(settings["repeats"], device.name)), options.output)


def _note(repeats: int, device: str) -> str:
    left_out = "" if freefem.installed() else " FreeFEM is not installed and left out."
    return (
        f"Centred sinc; off centre: by 2.9 mm. Warm, median of {repeats}; processor time of all "
        f"threads. OpenCL: {device}; a batch has {BATCH} films. CN: Crank–Nicolson. Runs longer "
        f"than that of a line's last dot were not made.{left_out}"
    )

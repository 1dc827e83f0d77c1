# What all stages share: the study, what makes results anew, the call of a command.

import atexit
import hashlib
import json
import sys
from pathlib import Path
from shlex import quote

LIBRARY = Path(workflow.current_basedir).parent.resolve()
IS_MODULE = not workflow.modifier.is_main_snakefile()
sys.path.insert(0, str(LIBRARY))

from squeezefilm.files import digest as file_digest, remove_parts, write_text
from squeezefilm.errors import InputError
from squeezefilm.provenance import SOURCES, code_digest
from squeezefilm.config.loading import configfiles_in, load_config, write_effective, written_study


def refuse(message):
    """End with a message for the reader: no traceback, and before anything runs."""
    print(f"squeezefilm: error: {message}", file=sys.stderr)
    sys.exit(2)


def relative(path):
    """The path from the working directory: the same in every copy of the checkout.

    In a module it stays absolute, or the module's prefix would be put before it.
    """
    path = Path(path).resolve()
    if IS_MODULE:
        return str(path)
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def config_path():
    """The one configuration file: the paper's, unless --configfile names another.

    Several files would be merged key by key, and a missing key would silently be the paper's. As a
    module of another workflow: the file into which the module's config is written.
    """
    if IS_MODULE:
        return relative(written_study(config, results=Path("results")))
    if workflow.config_settings.config:
        raise InputError(
            "--config sets single keys past the file's checks; write a file and give --configfile"
        )
    named = workflow.overwrite_configfiles
    if len(several := max(named, configfiles_in(sys.argv[1:]), key=len)) > 1:
        raise InputError(
            f"--configfile names {' and '.join(map(str, several))}: give one, for a mixture would "
            "be a study that nobody wrote down"
        )
    return relative(named[0] if named else LIBRARY.parent / "config" / "paper.yaml")


try:
    CONFIG_FILE = config_path()
    CONFIG = load_config(CONFIG_FILE)
except InputError as error:
    refuse(error)
# All that scripts read of Snakemake's configuration.
config = {"study_file": CONFIG_FILE}
STUDY = CONFIG.study
# Claims, tables and figures of the paper mean nothing in a study of another actuator.
PAPER = CONFIG.paper
SUMMARY = "1 Summary and claims" if PAPER else "1 Summary"
SCAN = getattr(CONFIG.actuator.profile, "file", None)
OUTLINE = CONFIG.pad.outline and CONFIG.pad.outline.file
STYLE = CONFIG.figures.style
MEASURED = CONFIG.measurements and CONFIG.measurements.file

# What decides a job's numbers beside its input files are parameters of its rule, so that Snakemake
# makes anew what an edit reaches: a digest of its stage's code, and sections of the study.
CODE = {stage: code_digest(stage) for stage in SOURCES}
SHAPES = ["actuator", "pad"]
FILM = ["gas", *SHAPES]


def sections(*names):
    """Sections of the study, all if none is named, and what is in their files: a rule's parameter."""
    found = CONFIG.sections(*names)
    named = [
        CONFIG.path.parent / file
        for file, section in (
            (SCAN, "actuator"),
            (OUTLINE, "pad"),
            (STYLE, "figures"),
            (MEASURED, "measurements"),
        )
        if file and section in found
    ]
    found["files"] = [file_digest(file) for file in named if file.is_file()]
    # The same text however a number is written: 43270, 43270.0 or 43.27 kHz.
    return json.dumps(json.loads(json.dumps(found), parse_int=float), sort_keys=True)


def checked_study():
    """The number of chunks by plan, of a study that is checked; kept, for that takes a second."""
    key = hashlib.sha256(f"{CODE['models']} {sections()}".encode()).hexdigest()[:16]
    kept = Path(".snakemake") / "squeezefilm" / f"{key}.json"
    if kept.exists():
        return json.loads(kept.read_text())
    from squeezefilm.models.force_model import check_models
    from squeezefilm.studies.plans import chunk_counts
    from squeezefilm.studies.study import check_study

    check_study(CONFIG)
    check_models(CONFIG)
    if STYLE:
        from reporting.figures.style import read_style

        read_style(CONFIG.path.parent / STYLE)
    write_text(json.dumps(chunk_counts(CONFIG)), kept)
    return json.loads(kept.read_text())


try:
    CHUNKS = checked_study()
except InputError as error:
    refuse(error)


pathvars:
    results=f"results/{STUDY}",
    logs=f"logs/{STUDY}",
    benchmarks=f"benchmarks/{STUDY}",


# A scan is smoothed once, before all else, and every command that reads the actuator reads what
# came of it.
SMOOTHED = "<results>/profile/smoothed.pickle" if SCAN else []
# What a scan leaves open is part of a fit's error.
SCAN_SUMMARY = "<results>/profile/summary.json" if SCAN else []


PLAN = "<results>/simulations/{plan}"
# The plans: sections of the study that decide their points, and what they are made from beside these,
# a design, or the fits that an extrapolation is beyond.
PLANS = {
    "screen": (["screen"], []),
    "error_map": (["error_map"], []),
    "extrapolation": (["extrapolation"], ["fits/screen.json", "fits/two_factor_design.json"]),
    "two_factor_design": ([], ["designs/two_factor.csv"]),
    "four_factor": (["positions"], ["designs/two_factor.csv"]),
    "four_factor_control": (["four_factor_control", "screen", "positions"], []),
    "four_factor_design": ([], ["designs/four_factor.csv"]),
    "four_factor_design_distinct": ([], ["designs/four_factor_distinct.csv"]),
    "validation_two_factor": (["validation", "screen", "positions"], []),
    "validation_four_factor": (["validation", "screen", "positions"], []),
    "sweep": (["sweep", "screen", "positions"], []),
}
# Spaces, each with one of the paper's models of this name; the plans that it is fitted to, the whole
# one first, and those that its fits are validated on. A fit bears the name of its plan.
FITS = {
    "two_factor": ["screen", "two_factor_design"],
    "four_factor": ["four_factor", "four_factor_design", "four_factor_design_distinct"],
}
JUDGED_ON = {
    "two_factor": ["screen", "error_map", "extrapolation"],
    "four_factor": ["four_factor", *(["four_factor_control"] if PAPER else [])],
}
MODEL_OF_FIT = {fit: space for space, fits in FITS.items() for fit in fits}


def sources_of_plan(wildcards):
    return expand("<results>/{file}", file=PLANS[wildcards.plan][1])


def code_of_plan(wildcards):
    return CODE["models" if wildcards.plan == "extrapolation" else "solver"]


def chunk_files(wildcards, kind):
    """The files of the chunks in which a plan is simulated; their number is known from the start."""
    chunks = CHUNKS[wildcards.plan]
    return [
        f"{PLAN}/chunks/{chunk}-of-{chunks}{kind}.{{suffix}}".format(**wildcards)
        for chunk in range(1, chunks + 1)
    ]


def validations(space):
    """Each fit of one of the paper's models, and each plan that it is judged on."""
    return expand("{fit}_on_{plan}", fit=FITS[space], plan=JUDGED_ON[space])


def results_folder(wildcards, output):
    """The folder of the study's results, of which any output is a part."""
    return f"{str(output[0]).partition(f'results/{STUDY}/')[0]}results/{STUDY}"


def limit_tables(space):
    """The asymptotic forces at the points that a space's models are fitted to or validated on."""
    plans = [FITS[space][0], f"validation_{space}"]
    return expand("<results>/simulations/{plan}/limits.csv", plan=plans)


def candidates(space):
    """The models that are compared in a space beside its own, of which there is a fit already."""
    return [model for model in CONFIG.comparison.of(space) if model != space]


def candidate_files(space):
    """The fits of the models that are compared in a space beside its own."""
    return expand(f"<results>/models/{space}/{{model}}.json", model=candidates(space))


def refined_files(space):
    """All that the refinement of a space's models leaves."""
    models = CONFIG.refine.of(space)
    return expand(f"<results>/refine/{space}/{{model}}/{{name}}", model=models, name=REFINED)


def cores_for(searches):
    """Cores that so many searches of a fit or a design are worth: others need not wait for it."""
    return max(1, min(4, searches // 4, (workflow.cores or 8) // 2))


def listed(file, category, *, caption, **labels):
    """A page or a figure as the report lists it."""
    place = f"../report/captions/{caption}.rst"
    return report(f"<results>/{file}", category=category, labels=labels, caption=place)


def pictures(place):
    """The files of a figure, by its place among the results."""
    return expand(f"<results>/{place}.{{format}}", format=["png", "svg"])


def drawing(place):
    """A figure's drawing as the report lists it, with what is bold in its caption."""
    folder, name = place.split("/")
    caption = {"models": "model_errors", "designs": "sensitivity", "refine": "refined"}
    caption = caption.get(folder, name)
    text = (LIBRARY / f"report/captions/{caption}.rst").read_text(encoding="utf-8")
    shows = text.split("**")[1].rpartition(": ")[2].rstrip(".")
    return listed(
        f"{place}.svg",
        CATEGORIES[folder],
        caption=caption,
        figure=name.replace("fig", "Fig. ").replace("_", " "),
        shows=shows[0].upper() + shows[1:],
    )


# Put before the command of every job. The library is found installed or not. Threads of BLAS that
# wait for work count as processor time, and a job has its own processes. A job on a cluster's node
# keeps its compiled kernels there, in Snakemake's tmpdir: home directories are shared by nodes that
# may differ, over a network that may not lock.
shell.prefix(
    "set -euo pipefail; export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 "
    + ("SQUEEZEFILM_NODE_CACHE=${{TMPDIR:-/tmp}} " if workflow.remote_exec else "")
    + (f"SQUEEZEFILM_SMOOTHED={quote(f'results/{STUDY}/profile/smoothed.pickle')} " if SCAN else "")
    + f"PYTHONPATH={quote(str(LIBRARY))}${{{{PYTHONPATH:+:$PYTHONPATH}}}}; "
)


wildcard_constraints:
    plan="|".join(PLANS),
    fit="|".join(MODEL_OF_FIT),
    chunk="[0-9]+",
    chunks="[0-9]+",
    suffix="csv|parquet",


onstart:
    try:
        remove_parts(Path("results") / STUDY)
        write_effective(CONFIG, Path("results") / STUDY)
    except InputError as error:
        refuse(error)


succeeded = []


onsuccess:
    succeeded.append(True)


@atexit.register
def name_page():
    """Name the page of the target, if there is one, last of all; also where nothing was to do."""
    ran = workflow.scheduler is not None and workflow.is_main_process and not workflow.dryrun
    if IS_MODULE or not ran or (len(workflow.dag) and not succeeded):
        return
    for job in sorted(workflow.dag.targetjobs, key=str):
        made = sorted(file for file in map(str, [*job.input, *job.output]) if Path(file).exists())
        files = [file for file in made if not file.endswith(".plain.png")]
        shown = [file for end in (".html", ".png") for file in files if file.endswith(end)]
        own = [file for file in shown if Path(file).stem in ("summary", job.rule.name)]
        for page in (own or shown)[:1]:
            print(f"Open {page}", flush=True)

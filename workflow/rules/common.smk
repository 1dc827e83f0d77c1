# What all stages share: the study, what makes results anew, the call of a command.

import hashlib
import json
import sys
import time
from functools import cache
from pathlib import Path
from shlex import quote

import yaml

# In a clone the packages lie beside the rules; rules that come from elsewhere use those installed.
RULES = Path(str(workflow.current_basedir))
IN_CLONE = (RULES.parent / "squeezefilm").is_dir()
if IN_CLONE:
    sys.path.insert(0, str(RULES.parent))


def refuse(message):
    """End with a message for the reader: no traceback, and before anything runs."""
    print(f"squeezefilm: error: {message}", file=sys.stderr)
    sys.exit(2)


try:
    from squeezefilm.files import file_digest, remove_partial_files, write_text
    from squeezefilm.errors import InputError
    from squeezefilm.provenance import CODE_PATHS_OF_STAGE, code_digest
    from squeezefilm.config.loading import load_config
    from squeezefilm.config.writing import write_effective_study, write_study_file
    from squeezefilm.table_writer import check_parquet_installed
    import squeezefilm_workflow
except ImportError as error:
    refuse(
        f"the rules call Python packages, of which {error.name} is not installed here; install "
        "them from the repository and the version of the rules: "
        "pip install 'squeezefilm[workflow] @ git+REPOSITORY@VERSION'"
    )


def in_folder(path):
    """A path from the working directory, if it lies there: the same in every copy of the folder."""
    path, folder = Path(path).resolve(), Path.cwd().resolve()
    return str(path.relative_to(folder) if path.is_relative_to(folder) else path)


def source_file(path):
    """A file that is not made here, as an input; a module's prefix is not put before it."""
    return local(in_folder(path))


# Another workflow gives the study as a mapping; in a clone's own it is a file.
IN_MODULE = "STUDY_FILES" not in globals()


def given_study():
    """The study: one file of --configfile, or the paper's; the config of another workflow.

    Several files would be merged key by key, and a missing key would silently be the paper's. The
    config that a module is given is written into a file.
    """
    if IN_MODULE:
        return load_config(write_study_file(config, results=Path("results")))
    files = [in_folder(path) for path in STUDY_FILES]
    if len(files) > 1:
        raise InputError(
            f"--configfile names {' and '.join(files)}: give one, for a mixture would be a study "
            "that nobody wrote down"
        )
    study = load_config(files[0] if files else in_folder(RULES.parents[1] / "config/paper.yaml"))
    if config != (yaml.safe_load(study.path.read_text("utf-8")) if files else {}):
        raise InputError(
            "--config sets single keys past the file's checks; write a file and give --configfile"
        )
    return study


try:
    CONFIG = given_study()
except InputError as error:
    refuse(error)
# All that scripts read of Snakemake's configuration.
config = {"study_file": str(CONFIG.path)}
STUDY = CONFIG.study
# Claims, tables and figures of the paper mean nothing in a study of another actuator.
PAPER = CONFIG.paper
# Numbers order the report's categories. A study of one's own has no tables of the paper; what some
# studies lack comes last.
CATEGORY = {
    name: f"{number} {name}"
    for number, name in enumerate(
        ["Summary and claims" if PAPER else "Summary"]
        + ["Tables"] * PAPER
        + ["Figures", "Models", "Designs and refinement", "Check", "Numerics"],
        start=1,
    )
}
SUMMARY = next(iter(CATEGORY.values()))
SCAN = getattr(CONFIG.actuator.profile, "file", None)
OUTLINE = CONFIG.pad.outline and CONFIG.pad.outline.file
STYLE = CONFIG.figures.style
MEASURED = CONFIG.measurements and CONFIG.measurements.file

# What decides a job's numbers beside its input files are parameters of its rule, so that Snakemake
# makes anew what an edit reaches: a digest of its stage's code, and sections of the study.
CODE = {stage: code_digest(stage) for stage in CODE_PATHS_OF_STAGE}


@cache
def code_of(stage, script):
    """A digest of the code that decides what is made, a stage's and a script's."""
    return f"{CODE[stage]} {file_digest(Path(workflow.source_path(f'../scripts/{script}.py')))}"


SHAPES = ["actuator", "pad"]
FILM = ["gas", *SHAPES]


def sections(*names):
    """Sections of the study, all if none is named, and what is in their files: a rule's parameter."""
    found = CONFIG.sections_as_dict(*names)
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
    from squeezefilm.config.notes import target_force_notes, unit_notes
    from squeezefilm.models.force_model import check_models_of_study
    from squeezefilm.studies.plans import chunk_counts
    from squeezefilm.studies.study import check_study

    check_study(CONFIG)
    check_models_of_study(CONFIG)
    for note in (*target_force_notes(CONFIG), *unit_notes(CONFIG)):
        print(f"note: {note}", file=sys.stderr)
    if STYLE:
        from squeezefilm_workflow.reporting.figures.style import read_style

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
SMOOTHED = "<results>/profile/smoothed.npz" if SCAN else []
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


def stage_of_plan(plan):
    return "models" if plan == "extrapolation" else "solver"


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


def limit_tables(space):
    """The asymptotic forces at the points that a space's models are fitted to or validated on."""
    plans = [FITS[space][0], f"validation_{space}"]
    return expand("<results>/simulations/{plan}/limits.csv", plan=plans)


def candidates(space):
    """The models that are compared in a space beside its own, of which there is a fit already."""
    return [model for model in CONFIG.comparison.names_of_space(space) if model != space]


def candidate_files(space):
    """The fits of the models that are compared in a space beside its own."""
    return expand(f"<results>/models/{space}/{{model}}.json", model=candidates(space))


def refined_files(space):
    """All that the refinement of a space's models leaves."""
    models = CONFIG.refine.names_of_space(space)
    return expand(f"<results>/refine/{space}/{{model}}/{{name}}", model=models, name=REFINED)


def cores_for(searches):
    """Cores that so many searches of a fit or a design are worth: others need not wait for it."""
    return max(1, min(4, searches // 4, (workflow.cores or 8) // 2))


def growing(limit):
    """A limit of memory or of minutes; a job that it ended has more at each further attempt."""
    return lambda wildcards, attempt: limit * attempt


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
    text = Path(workflow.source_path(f"../report/captions/{caption}.rst")).read_text("utf-8")
    shows = text.split("**")[1].rpartition(": ")[2].rstrip(".")
    return listed(
        f"{place}.svg",
        CATEGORIES[folder],
        caption=caption,
        figure=name.replace("fig", "Fig. ").replace("_", " "),
        shows=shows[0].upper() + shows[1:],
    )


# Put before the command of every job. Threads of BLAS that wait for work count as processor time,
# and a job has its own processes.
shell.prefix(
    "set -euo pipefail; export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 "
    + (
        f"PYTHONPATH={quote(str(RULES.parent))}${{{{PYTHONPATH:+:$PYTHONPATH}}}}"
        if IN_CLONE
        else ""
    )
    + "; "
)


wildcard_constraints:
    plan="|".join(PLANS),
    fit="|".join(MODEL_OF_FIT),
    chunk="[0-9]+",
    chunks="[0-9]+",
    suffix="csv|parquet",


onstart:
    try:
        # Tables of a sweep are in Parquet; the package for it is no part of the environment.
        if "sweep" in map(str, workflow.dag_settings.targets):
            check_parquet_installed()
        remove_partial_files(Path("results") / STUDY)
        write_effective_study(CONFIG, Path("results") / STUDY)
    except InputError as error:
        refuse(error)


REFERENCE = RULES.parents[1] / "tests" / "reference" / STUDY


def reference_files(wildcards):
    """The study's stored reference, which is missed before anything is made."""
    paths = sorted(REFERENCE.glob("*.*"))
    if not paths:
        from snakemake.exceptions import WorkflowError
        from squeezefilm_workflow.reporting.check import missing_reference_text

        raise WorkflowError(missing_reference_text(REFERENCE))
    return [source_file(path) for path in paths]


# Pages that show what others show too, the last one to be made first.
FRONT_PAGES = ["check", "equations", "summary"]
STARTED_S = time.time()


# Names the pages and figures that were asked for, or the page to look at first; where neither was
# made, as by a sweep, tables of forces.
onsuccess:
    made = [
        path for path in Path("results", STUDY).rglob("*.*") if path.stat().st_mtime > STARTED_S
    ]
    pages = [path for path in made if path.suffix == ".html"]
    fronts = [path for name in FRONT_PAGES for path in pages if path.stem == name]
    figures = [path for path in made if path.suffix == ".png" and ".plain" not in path.name]
    targets = {Path(str(target)).stem for target in workflow.dag_settings.targets}
    asked = sorted(path for path in [*pages, *figures] if path.stem in targets)
    shown = asked or [*fronts, *sorted(pages), *sorted(figures)][:1]
    for page in shown:
        print(f"Open {page}", flush=True)
    for table in sorted(path for path in made if path.stem == "forces" and not shown):
        print(f"Forces: {table}", flush=True)

# What all stages share: the configuration, what a command rests on, the call of a command.

import sys
from pathlib import Path
from shlex import quote

LIBRARY = Path(workflow.current_basedir).parent.resolve()
IS_MODULE = not workflow.modifier.is_main_snakefile()
sys.path.insert(0, str(LIBRARY))

from snakemake.logging import logger
from squeezefilm.io import atomic
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.runs import console, locks, run_card
from squeezefilm.runs.basis import basis_file, forget_others
from squeezefilm.runs.checked import checked_study
from squeezefilm.runs.code import Code
from squeezefilm.studies import given
from squeezefilm.studies.effective import write_effective


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

    Several files would be merged key by key, and a key left out would silently be the paper's. As a
    module of another workflow: the file into which the module's config is written.
    """
    if IS_MODULE:
        return relative(given.written_study(config, results=Path("results")))
    if workflow.config_settings.config:
        raise InputError(
            "--config sets single keys past the file's checks; write a file and give --configfile"
        )
    named = workflow.overwrite_configfiles
    if len(several := max(named, given.configfiles_in(sys.argv[1:]), key=len)) > 1:
        raise InputError(
            f"--configfile names {' and '.join(map(str, several))}: give one, for a mixture would "
            "be a study that nobody wrote down"
        )
    return relative(named[0] if named else LIBRARY.parent / "config" / "paper.yaml")


try:
    MEMORY = Path(".snakemake") / "squeezefilm"
    CODE = Code(memory=MEMORY / "code.json")
    CONFIG_FILE = config_path()
    CHECKED = checked_study(Path(CONFIG_FILE), code=CODE, memory=MEMORY)
except InputError as error:
    refuse(error)
CONFIG, SCAN, OUTLINE = CHECKED.config, CHECKED.scan, CHECKED.outline
STUDY = CONFIG["study"]
# Claims, tables and figures of the paper mean nothing in a study of another actuator.
PAPER = CONFIG["paper"]


pathvars:
    results=f"results/{STUDY}",
    logs=f"logs/{STUDY}",
    benchmarks=f"benchmarks/{STUDY}",


BASES = set()


def code(command, *modules, key=None):
    """What decides the results of a command, as one file to name as a rule's input.

    It stands for the code, that of modules which the command loads by a name made at run time too,
    and the sections of the study that they read, with the scan of a measured profile
    and the outline of the finger. ``key`` is
    the kind of work where what is read goes by it. To be called while the rules are read: Snakemake
    looks which files there are before it asks a rule's functions.
    """
    sections = CODE.sections(command, *modules, key=key)
    try:
        basis = basis_file(
            Path("results") / STUDY / "basis",
            "-".join([command, *filter(None, [key]), *modules]),
            code=CODE,
            files=CODE.of(command, *modules),
            sections={name: CONFIG[name] for name in sections},
            data=[
                file
                for file, section in ((SCAN, "actuator"), (OUTLINE, "finger"))
                if file and section in sections
            ],
        )
    except InputError as error:
        refuse(error)
    BASES.add(basis)
    if SCAN and "actuator" in sections and command != "smooth":
        return [relative(basis), SMOOTHED]
    return relative(basis)


# A scan is smoothed once, and every command that reads the actuator reads what came of it.
SMOOTHED = "<results>/profile/smoothed.npz"
# What a scan leaves open is part of a fit's error.
SCAN_SUMMARY = "<results>/profile/summary.json" if SCAN else []
WITH_SCAN = "--scan {input.scan} " if SCAN else ""


def chunk_files(plan, suffix):
    """The files of the chunks in which a plan is simulated; their number is known from the start."""
    chunks = CHECKED.chunks.get(plan, 1)
    return [
        f"<results>/simulations/{plan}/chunks/{chunk}-of-{chunks}{suffix}"
        for chunk in range(1, chunks + 1)
    ]


def cores_for(searches):
    """Cores that so many searches of a fit or a design are worth: starting a process costs too."""
    return max(1, min(4, searches // 4))


def validations(model, plans):
    """The names of a model's validations: each of its fits on each of the plans."""
    fits = [fit for fit in FITS if MODEL_OF_FIT[fit] == model]
    return [f"{fit}_on_{plan}" for fit in fits for plan in plans]


# One run at a time makes a study; its jobs know it by name, also those that run elsewhere.
CARDS = Path("results") / STUDY / "run_cards"
MAIN = workflow.is_main_process
OWNER = locks.new_owner() if MAIN else locks.read_owner(CARDS)
# A module's handlers (onstart …) are not called: its runs have no cards.
RUN = str(CARDS / OWNER.run) if OWNER and not IS_MODULE else ""


# Put before every command of every rule: the library is found installed or not, and the python is
# that of the environment that runs snakemake, unless a conda environment is activated after it. A
# job on a cluster's node keeps its compiled kernels there, in Snakemake's tmpdir: home directories
# are shared by nodes that may differ, over a network that may not lock.
shell.prefix(
    "set -euo pipefail; "
    + ("export SQUEEZEFILM_NODE_CACHE=${{TMPDIR:-/tmp}}; " if workflow.remote_exec else "")
    + f"export PATH={quote(str(Path(sys.executable).parent))}:$PATH "
    f"PYTHONPATH={quote(str(LIBRARY))}${{{{PYTHONPATH:+:$PYTHONPATH}}}} SQUEEZEFILM_RUN={quote(RUN)} "
    + (f"SQUEEZEFILM_SMOOTHED={quote(f'results/{STUDY}/profile/smoothed.npz')}" if SCAN else "")
    + "; "
)


PLANS = [
    "sweep",
    "screen",
    "error_map",
    "two_factor_design",
    "extrapolation",
    "four_factor",
    "four_factor_control",
    "validation_two_factor",
    "validation_four_factor",
    "four_factor_design",
    "four_factor_design_distinct",
]
FITS = [
    "screen",
    "two_factor_design",
    "four_factor",
    "four_factor_design",
    "four_factor_design_distinct",
]


wildcard_constraints:
    plan="|".join(PLANS),
    fit="|".join(FITS),
    chunk="[0-9]+",
    chunks="[0-9]+",


for folder in (CARDS.parent.parent, CARDS.parent):
    if folder.exists() and not folder.is_dir():
        refuse(f"{folder} is a file; the results are to be in a folder of this name")
ATTENDED = locks.attend(Path.cwd()) if MAIN else None

# Snakemake refuses a second run too, but does not say whose the first one is.
if MAIN and not workflow.output_settings.dryrun and locks.is_held(CARDS):
    print(f"squeezefilm: note: {locks.held_by(CARDS)}", file=sys.stderr)


# A line for each job; who asks for more, and a workflow that this is a module of, has Snakemake's.
ASKED = workflow.output_settings
if MAIN and not IS_MODULE and not (ASKED.dryrun or ASKED.verbose or ASKED.printshellcmds):
    console.quieten(
        logger,
        about=f"Study {STUDY}, on {workflow.cores} cores, into {CARDS.parent}",
        pace_s=console.pace(CARDS.parent.parent, host=OWNER.host),
    )


def begin_run():
    """Take the study and begin the run's card."""
    global HELD
    try:
        HELD = locks.hold(CARDS, OWNER)
        atomic.remove_parts(CARDS.parent)
        for basis in BASES:
            forget_others(basis)
        run_card.begin(
            CARDS,
            OWNER,
            config=CONFIG,
            command=sys.argv,
            cores=workflow.cores,
        )
        write_effective(CONFIG, CARDS.parent)
    except (InputError, RunError) as error:
        refuse(error)


def end_run(outcome):
    """Complete the run's card; the next run does it where that fails."""
    try:
        run_card.end(CARDS, OWNER, outcome=outcome)
    except InputError as error:
        print(f"squeezefilm: note: {error}", file=sys.stderr)


onstart:
    if MAIN:
        begin_run()


onsuccess:
    if MAIN:
        end_run(run_card.COMPLETED)
        for line in console.where_to_look(CARDS.parent):
            print(line, file=sys.stderr)


onerror:
    if MAIN:
        end_run(run_card.FAILED)

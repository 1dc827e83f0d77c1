"""Into how many jobs the simulations of a plan are divided, by what its scenes should cost.

Only the configuration is asked: the number of jobs is known before any plan is made.
"""

from math import ceil

from squeezefilm.config.loading import Config
from squeezefilm.errors import InputError
from squeezefilm.reynolds.plan import previews
from squeezefilm.solution import form_of
from squeezefilm.studies.plans import box_of, plan_sizes, random_plan
from squeezefilm.studies.study import planned_profile_of, scenes_in

# One thread of an AMD EPYC (Zen 5, registers of 64 bytes), 60 and 65 scenes of the paper at 1e-3 to
# 1e-8: processor time, fitted.
MFLOP_PER_SECOND = 42_000.0
# Besides the operations: preparing and collecting, where each scene has a place of its own; where
# scenes share them, as in most small plans, a fifth of it.
SECONDS_PER_SCENE = 3e-4
# Outputs ask for states on two grids more, closely solved, and for Python's time.
TIMES_FOR_OUTPUTS, SECONDS_OF_OUTPUTS = 4, 1e-2
SAMPLE = 32
MOST_CHUNKS = 20_000
CENTRED = ("screen", "error_map")


def chunk_counts(config: Config) -> dict[str, int]:
    """The number of jobs for each plan, of about ``simulation.seconds_per_job`` each.

    Raises InputError when a plan would need more jobs than a workflow can handle.
    """
    target = config["simulation"]["seconds_per_job"]
    counts = {}
    for plan, points in plan_sizes(config).items():
        seconds = points * expected_seconds(config, centred=plan in CENTRED)
        counts[plan] = min(points, max(1, ceil(seconds / target)))
        if counts[plan] > MOST_CHUNKS:
            raise InputError(
                f"{config.path}: simulation.seconds_per_job: {target:g} s make {counts[plan]} jobs "
                f"of the plan {plan}; at most {MOST_CHUNKS} are possible, so give at least "
                f"{seconds / MOST_CHUNKS:.2g}"
            )
    return counts


def expected_seconds(config: Config, *, centred: bool) -> float:
    """Mean time of a scene on one thread, from a few random scenes of the study."""
    sample = random_plan(points=SAMPLE, seed=1, **box_of(config).ranges)
    if centred:
        sample = sample.assign(**dict.fromkeys(form_of(sample), 0.0))
    profile = planned_profile_of(config)
    scenes = scenes_in(sample, config, profile=profile)
    solver = config["solver"]
    planned = previews(scenes, tolerance=solver["tolerance"], method=solver["method"])
    mflop = sum(each.expected_mflop for each in planned) / SAMPLE
    seconds = SECONDS_PER_SCENE + mflop / MFLOP_PER_SECOND
    return seconds * TIMES_FOR_OUTPUTS + SECONDS_OF_OUTPUTS if config["outputs"] else seconds

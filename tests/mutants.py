"""One wrong sign or factor in each formula: the tests beside it must find it.

python tests/mutants.py [NAME …] puts each into a copy of the checkout and runs its tests there. A
mutation that no test finds is printed, and the exit status is 1.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COPIED = ("workflow", "tests", "config", "docs", "pyproject.toml", "README.md")
NUMERICS, UNIT = "tests/numerics", "tests/unit"
FOUND, SOUND = 1, 0  # pytest's exit status
# How a test ends that did not get to a number.
NO_NUMBER = ("BUILD_PROGRAM_FAILURE", "SyntaxError", "ImportError")


@dataclass(frozen=True)
class Mutation:
    """A formula made wrong.

    Attributes:
        file: below workflow/squeezefilm.
        sound, wrong: what stands there once, and what is put in its place.
        tests: those that must find it.
    """

    file: str
    sound: str
    wrong: str
    tests: tuple[str, ...]


MUTATIONS = {
    "gap": Mutation(
        "reynolds/periodic/grid_over_period.cl",
        "(parts[row] * g->sine[t] + parts[g->rows + row] * g->cosine[t])",
        "(parts[row] * g->sine[t] - parts[g->rows + row] * g->cosine[t])",
        (f"{NUMERICS}/test_any_gap.py::test_a_standing_wave_may_begin_at_any_instant",),
    ),
    "bearing": Mutation(
        "reynolds/terms/bearing_over_period.cl",
        "out4[i] -= speed * beyond_even(",
        "out4[i] += speed * beyond_even(",
        (
            f"{NUMERICS}/test_reynolds_limits.py::test_divergence_form_of_the_equation_holds"
            "_with_every_term",
        ),
    ),
    "inertia": Mutation(
        "reynolds/terms/inertia_over_period.cl",
        "((matrix4)rate)[i] - u[i] * filling[i] / 7.0",
        "((matrix4)rate)[i] + u[i] * filling[i] / 7.0",
        (f"{NUMERICS}/test_inertia.py::test_small_motion_has_the_second_order_force",),
    ),
    "thermal": Mutation(
        "reynolds/terms/thermal_over_period.cl",
        "share = lighter + kappa * thicker",
        "share = lighter - kappa * thicker",
        (
            f"{NUMERICS}/test_inertia.py::test_the_middle_of_a_long_pad_is_the_strip"
            "[0.2-583.0-1.81-included]",
        ),
    ),
    "rarefaction": Mutation(
        "reynolds/terms/rarefaction_over_period.cl",
        "*potential += over_gap * by_pressure",
        "*potential -= over_gap * by_pressure",
        (
            f"{NUMERICS}/test_terms.py::test_a_film_with_the_flow_factor_solves_the_equation"
            "_as_it_is_written",
        ),
    ),
    "polytropic": Mutation(
        "reynolds/terms/polytropic_over_period.cl",
        "expm1(film->row->inverse_exponent * log1p(p))",
        "expm1(-film->row->inverse_exponent * log1p(p))",
        (f"{NUMERICS}/test_terms.py::test_fast_adiabatic_compression_is_stiffer_by_the_exponent",),
    ),
    "edge pressure": Mutation(
        "quantities/edge_effects.py",
        "around - loss * reynolds",
        "around + loss * reynolds",
        (f"{NUMERICS}/test_budget.py::test_the_edge_loss_is_that_of_a_strip_at_every_order",),
    ),
    "edge inertance": Mutation(
        "quantities/edge_effects.py",
        "around += inertance",
        "around -= inertance",
        (
            f"{NUMERICS}/test_all_effects.py::test_flow_around_the_edge_is_that_of_an_independent_program",
        ),
    ),
    "outline": Mutation(
        "reynolds/terms/outline_over_period.cl",
        "out4[i] -= film->sigma * stretch[row] *",
        "out4[i] += film->sigma * stretch[row] *",
        (f"{NUMERICS}/test_outlines.py::test_an_ellipse_has_its_fast_limit",),
    ),
    "response": Mutation(
        "dynamics/averaged_film.py",
        "at_once + complex(by_flow)",
        "at_once - complex(by_flow)",
        (f"{NUMERICS}/test_slow_film.py",),
    ),
    "force integral": Mutation(
        "reynolds/periodic/periodic.cl",
        "sum += g->weights[row] * over_period;",
        "sum += 0.999 * g->weights[row] * over_period;",
        (f"{NUMERICS}/test_reynolds_limits.py::test_second_order_of_the_periodic_state",),
    ),
    "fit": Mutation(
        "models/models.yaml",
        "sqrt(1 - theta1*(hv/h0)**2) + theta2\n",
        "sqrt(1 + theta1*(hv/h0)**2) + theta2\n",
        (f"{UNIT}/test_force_model.py::test_the_piston_formula_is_a_case_of_the_model",),
    ),
    "D-criterion": Mutation(
        "designs/paper_design.py",
        "np.sum(1 / np.maximum(pair_distances(points), 1 / SINGULAR_CRITERION_VALUE), axis=-1)",
        "np.sum(0.5 / np.maximum(pair_distances(points), 1 / SINGULAR_CRITERION_VALUE), axis=-1)",
        (f"{UNIT}/test_paper_design.py::test_the_searches_end_in_two_patterns",),
    ),
}


def run_tests(folder: Path, tests: tuple[str, ...]) -> tuple[int, str]:
    """Return pytest's exit status in a copy of the checkout, and what it printed."""
    words = ("-q", "-x", "-p", "no:cacheprovider", "--basetemp", str(folder.parent / "pytest"))
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words, *tests],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


def outcome(name: str, folder: Path) -> str:
    """Return how the tests of a mutation end without it and with it: ``found``, or what is not."""
    mutation = MUTATIONS[name]
    path = folder / "workflow/squeezefilm" / mutation.file
    text = path.read_text(encoding="utf-8")
    if text.count(mutation.sound) != 1:
        return (
            f"{mutation.file} has {mutation.sound!r} {text.count(mutation.sound)} times, not once"
        )
    status, printed = run_tests(folder, mutation.tests)
    if status != SOUND:
        return f"its tests fail without it:\n{printed[-2000:]}"
    path.write_text(text.replace(mutation.sound, mutation.wrong), encoding="utf-8")
    try:
        status, printed = run_tests(folder, mutation.tests)
    finally:
        path.write_text(text, encoding="utf-8")
    if status == FOUND and not any(word in printed for word in NO_NUMBER):
        return "found"
    return f"NOT FOUND, pytest's exit status is {status}:\n{printed[-2000:]}"


def main(*names: str) -> int:
    if unknown := {*names} - {*MUTATIONS}:
        print(f"{', '.join(sorted(unknown))}: no mutation; there are {', '.join(MUTATIONS)}")
        return 2
    missed = 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "checkout"
        folder.mkdir()
        for part in COPIED:
            copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
            copy(ROOT / part, folder / part)
        for name in names or MUTATIONS:
            told = outcome(name, folder)
            missed += told != "found"
            print(f"{name}: {told}", flush=True)
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

"""A newcomer's machine: Debian with what README names, and no compiler's cache."""

import re
from pathlib import Path

import pytest

from .machine import Machine, fresh_machine, missing_for_a_machine

MISSING = missing_for_a_machine()
pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)


def steps(repository: Path) -> list[str]:
    """The commands of the Containerfile, in order."""
    lines = (repository / "Containerfile").read_text(encoding="utf-8").replace("\\\n", "")
    return re.findall(r"^RUN (.*)$", lines, re.MULTILINE)


def install(machine: Machine, repository: Path) -> None:
    """Follow the Containerfile; what is not Debian's is made by the user."""
    of_debian, of_repository = steps(repository)
    machine.run(of_debian, user="root")
    machine.run(of_repository)


def test_quick_and_the_unit_tests_on_debian_12(repository: Path) -> None:
    with fresh_machine("bookworm", repository) as machine:
        install(machine, repository)
        printed = machine.run("make quick")
        assert "warnings generated" not in printed
        assert (machine.clone / "results/quick/simulations/device.json").exists()
        tested = machine.run(
            "make .venv/.dev && PATH=$PWD/.venv/bin:$PATH OPENBLAS_NUM_THREADS=1 "
            "pytest -n 2 tests/unit"
        )
        print(tested.splitlines()[-1])


@pytest.mark.parametrize("release", ["bookworm", "trixie"])
def test_the_paper_and_all_tests(release: str, repository: Path) -> None:
    with fresh_machine(release, repository) as machine:
        install(machine, repository)
        assert "warnings generated" not in machine.run("make paper")
        assert (machine.clone / "results/paper/claims.csv").exists()
        print(machine.run("make test").splitlines()[-1])

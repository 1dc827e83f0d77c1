"""The commands that the docs tell a reader to type, and where each is run."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PAGES = (
    *("README.md", "CONTRIBUTING.md", "config/README.md", "results/README.md"),
    *("workflow/README.md", "tests/reference/README.md"),
)
PROGRAMS = "make|squeezefilm(?:-verification)?|snakemake|python|pip|pytest|apt|apt-get|podman"
STARTS = rf"(?:{PROGRAMS}|git|\. \.venv|[A-Z]+=\S+$)"
BLOCK_LINE = re.compile(rf"^    (?:\$ )?({STARTS}(?![\w:=-]).*)$", re.MULTILINE)
INLINE = re.compile(rf"(?<!`)`((?:{PROGRAMS}) [^`]+)`(?!`)")
SHOWN_LINE = re.compile(r"…$|\S.*\S {2,}\S")
"""A line of a result: a label and a value, or what is not shown."""
NAMES = {
    "squeezefilm": re.compile(r"squeezefilm ([a-z][a-z-]*)"),
    "verification": re.compile(r"squeezefilm-verification ([a-z][a-z-]*)"),
    "snakemake": re.compile(r"snakemake ([a-z][a-z0-9_ ]*)"),
}
"""Commands that a text may only name, such as `squeezefilm error-budget`, `snakemake refine`."""

MADE = "results/quick/simulations/screen"
PLACEHOLDERS = {
    "CONFIG.yaml": "config/paper.yaml",
    "SCENES.csv": f"{MADE}/scenes.csv",
    "/PLAN/": "/screen/",
    "results/paper/": "results/quick/",
    "results/paper --output": "results/quick --output",
    "STUDIES=mine": "STUDIES=my-actuator",
    "config/forty.yaml": "config/paper.yaml",
    "snakemake models --configfile config/mine.yaml": (
        "snakemake models --configfile config/my-actuator.yaml"
    ),
    "snakemake --configfile config/mine.yaml": "snakemake --configfile config/my-actuator.yaml",
    "make resume CONFIG=config/mine.yaml": "make resume CONFIG=config/my-actuator.yaml",
}
"""What stands for a file of the reader's own, the paper's study in small, another study's."""

SMALLER = {
    "squeezefilm new my-actuator": (
        "squeezefilm new my-actuator && sed -i 's/{start:/{levels: 4, start:/'"
        " config/my-actuator.yaml && cat sizes.yaml >> config/my-actuator.yaml"
    ),
    "make reference": "make reference STUDIES=my-actuator",
}
"""What is run in the place of a command: the same recipe for a study that is made already."""

ELSEWHERE = {
    "make quick": "make check",
    "make paper-inertia": "make check",
    "make report CONFIG=config/quick.yaml": "make report",
    "squeezefilm check results/quick --reference tests/reference/quick": "make test-check",
    "pip install .": "make test-install",
    "pip install '.[fields]'": "make test-install",
    "pip install snakemake-executor-plugin-slurm": "make test-cluster",
    "pip install snakemake-executor-plugin-cluster-generic": "make test-cluster",
    "snakemake --workflow-profile profiles/slurm": "make test-cluster",
    'make resume OPTIONS="--workflow-profile profiles/slurm"': "make test-cluster",
    "snakemake sweep --configfile config/sweep.yaml --workflow-profile profiles/slurm": (
        "make test-cluster"
    ),
}
"""Commands that a stage of .ci/run has."""

BY_HAND = {
    "git clone <this repository> && cd <its folder>": "the address is the reader's",
    "git clone <this repository> squeezefilm && make -C squeezefilm .venv/.run": (
        "the address is the reader's"
    ),
    "apt install python3 python3-venv make gcc libc6-dev": "a system's own packages",
    "git pull": "the address is the reader's",
    "make clean": "removes what the others made; a unit test runs the recipe",
    "pip uninstall squeezefilm": "removes what the others need",
    "podman build .": "needs a container engine and a registry",
    "make test-fresh": "an hour, and a root user",
    "squeezefilm-verification random-studies --studies 100 --seed 1 --output TABLE.csv": (
        "minutes; eleven such studies are a test"
    ),
    "squeezefilm-verification random-studies --coverage --studies 15 --fresh 2000 --seed 1 "
    "--output TABLE.csv": "about an hour",
    "squeezefilm-verification modelling-errors --films 120 --output TABLE.csv": (
        "ten minutes; some of these films are a test"
    ),
    "squeezefilm-verification auto-terms --films 200 --output TABLE.csv": "an hour",
    "squeezefilm-verification estimates --films 5000 --seed 41 --output FORCES.csv "
    "--summary TABLE.csv": "an hour of a core; four such films are a test",
    "make pictures": "minutes, and needs a machine where nothing else runs",
    "make benchmarks": "needs a machine where nothing else runs",
    "pip install pyarrow": "a part of requirements-dev.lock",
    "make lock": "takes the newest versions of all packages from the network",
}
"""Commands that nothing runs, and why."""


@dataclass(frozen=True)
class Command:
    """A command as it stands on a page."""

    page: str
    text: str
    in_a_sentence: bool

    @property
    def is_name(self) -> bool:
        named = any(pattern.fullmatch(self.text) for pattern in NAMES.values())
        return self.in_a_sentence and named


def pages(repository: Path) -> list[Path]:
    docs = sorted((repository / "docs").rglob("*.md"))
    written = [page for page in docs if page.parent.name != "_generated"]
    return [repository / name for name in PAGES] + written


def commands_on(page: Path, *, root: Path) -> Iterator[Command]:
    """Every command of a page, in its order, each once."""
    text = page.read_text(encoding="utf-8")
    joined = re.sub(r" \\\n\s+", " ", text)
    found = [
        (match.start(), match[1], pattern is INLINE)
        for pattern in (BLOCK_LINE, INLINE)
        for match in pattern.finditer(joined)
    ]
    name = page.relative_to(root).as_posix()
    for _, words, in_a_sentence in sorted(found):
        without_comment = re.split(r"\s+# ", words)[0]
        yield Command(name, " ".join(without_comment.split()), in_a_sentence)


def outputs_on(page: Path) -> Iterator[tuple[str, list[str]]]:
    """Every command of a page with the lines of output shown after it, in its block or the next."""
    command = ""
    for block in re.findall(r"(?:^    .*\n)+", page.read_text(encoding="utf-8"), re.MULTILINE):
        *before, rest = re.split(BLOCK_LINE, re.sub(r" \\\n\s+", " ", block))
        command = before[-1] if before else command
        lines = [" ".join(line.split()) for line in rest.splitlines() if line]
        shown = [line for line in rest.splitlines() if line]
        if command and shown and all(SHOWN_LINE.match(line.strip()) for line in shown):
            yield command, [line for line in lines if line != "…"]
            command = ""


OF_A_STUDY = ("my-actuator", "$FIT", "results/")
"""What a command names that needs the results of a study."""


def shown_on(repository: Path, *, of_a_study: bool) -> list[tuple[str, list[str]]]:
    """Every command with the lines shown of its output, of those with or without a study."""
    shown = [each for page in pages(repository) for each in outputs_on(page)]
    return [each for each in shown if any(map(each[0].count, OF_A_STUDY)) == of_a_study]


NUMBER = re.compile(r"(?<![\w.])[-+−]?\d+\.\d+(?:e[-+]?\d+)?")
"""A number with decimals: of a quantity that is computed, not counted."""


def _last_digit(number: str) -> float:
    """One unit of a number's last digit."""
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def same_text(shown: str, printed: str) -> bool:
    """Whether texts differ in no more than a unit of numbers' last digits.

    Processors round otherwise: one with AVX-512 adds up in another order.
    """
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return all(
        abs(float(one.replace("−", "-")) - float(other.replace("−", "-")))
        <= 1.01 * max(_last_digit(one), _last_digit(other))
        for one, other in pairs
    )


def missing_lines(shown: list[str], printed: list[str]) -> list[str]:
    """Lines that are shown and not printed, but the name of the device."""
    return [
        line
        for line in shown
        if not line.startswith("device ") and not any(same_text(line, other) for other in printed)
    ]


def all_commands(repository: Path) -> list[Command]:
    """Every command of the docs, each text once: where it stands first, of its own if it does."""
    every = [each for page in pages(repository) for each in commands_on(page, root=repository)]
    found = {each.text: each for each in reversed(every) if each.in_a_sentence}
    found |= {each.text: each for each in reversed(every) if not each.in_a_sentence}
    return sorted(found.values(), key=every.index)


def stages(repository: Path) -> list[str]:
    """What every change must pass."""
    lines = (repository / ".ci/run").read_text(encoding="utf-8").splitlines()
    words = [line.split()[1:] for line in lines if line.startswith("make ")]
    return [f"make {word}" for line in words for word in line if re.fullmatch("[a-z][a-z-]*", word)]


def to_run(repository: Path) -> list[Command]:
    """The commands that are run here: all but names and those that have another place."""
    elsewhere = {*stages(repository), *ELSEWHERE, *BY_HAND}
    return [
        command
        for command in all_commands(repository)
        if command.text not in elsewhere
        and not command.is_name
        and not command.text.startswith("pytest ")
    ]


def as_run(command: str) -> str:
    """What is typed for a command here."""
    if command in SMALLER:
        return SMALLER[command]
    for placeholder, path in PLACEHOLDERS.items():
        command = command.replace(placeholder, path)
    return command

"""Kill a running quick study many times, go on each time, and compare what comes out.

    python tests/faults/kill_many.py --folder /tmp/kills --output kills.csv

Each kill starts from nothing: a copy of the checkout makes TARGETS of the quick study, is killed
with SIGKILL, goes on as `make resume` does, and must end with every file equal, byte for byte, to
those of an undisturbed run (but for run times and run cards, which tell of the run itself). In turn
the whole process group, snakemake alone, or one job alone is killed.

56 of every 100 kills are spread evenly over the wall time of the undisturbed run; 12 each wait for
a job that simulates, fits or plots; 8 hit the compilation of the kernels with empty caches. What
ran at the moment of the kill is read from the process table. Parts of the quick study are left out
(TARGETS), for a hundred whole ones would take hours: what is left is a plan, its simulation, a fit
and two figures, one of the plan alone, which is drawn beside the simulation.

A hundred take about half an hour on two free cores. Not part of any test; test_faults.py holds the
quick ones.
"""

import argparse
import contextlib
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any

import pandas as pd
import psutil

CHECKOUT = Path(__file__).resolve().parents[2]
PARTS = ("Snakefile", "config", "envs", "profiles", "workflow")
TARGETS = ("fig07", "fig08")
SNAKEMAKE = (sys.executable, "-m", "snakemake", *TARGETS, "--configfile", "config/quick.yaml")
PACKAGES = ("squeezefilm", "verification", "reporting", "paper")
LIBRARY = (sys.executable, "-m", "squeezefilm")
VICTIMS = ("group", "snakemake", "job")
STAGES = {"simulate": "simulation", "fit": "fit", "figure": "plotting", "warm": "compilation"}
PATIENCE_S = 900


@dataclass(frozen=True)
class Kill:
    """A row of the table: one kill and what became of it."""

    number: int
    aim: str
    moment_s: float
    ran: str
    killed: str
    resumed: bool
    digests_equal: bool
    traced: bool
    remade_s: float
    note: str


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--folder", type=Path, required=True, help="scratch folder, emptied first")
    parser.add_argument("--output", type=Path, required=True, help="table of the kills")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    folder: Path = options.folder.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    environment = {**os.environ, "PYTHONPATH": str(folder / "workflow")}
    environment.pop("SQUEEZEFILM_RUN", None)
    fresh(folder)
    start = time.monotonic()
    subprocess.run(SNAKEMAKE, cwd=folder, env=environment, check=True, capture_output=True)
    wall_s = time.monotonic() - start
    wanted = digests(folder)
    print(f"undisturbed: {wall_s:.1f} s, {len(wanted)} files", flush=True)
    kills: list[Kill] = []
    aims = plan(options.kills, random.Random(options.seed))
    for number, (aim, moment_s) in enumerate(aims, start=1):
        if aim == "wall time":
            aim, moment_s = f"{moment_s:.0%} of the run", moment_s * wall_s
        kill = one_kill(
            number, aim, moment_s, folder=folder, environment=environment, wanted=wanted
        )
        kills.append(kill)
        pd.DataFrame(map(asdict, kills)).to_csv(options.output, index=False)
        print(kill, flush=True)
    print(summary(kills))
    return 0 if all(kill.resumed and kill.digests_equal and kill.traced for kill in kills) else 1


def plan(kills: int, draw: random.Random) -> list[tuple[str, float]]:
    """What each kill aims at: a stage and seconds into it, or a share of the whole wall time."""
    aimed = [("simulation", 12), ("fit", 12), ("plotting", 12), ("compilation", 8)]
    aims = [
        (stage, draw.uniform(0, 0.8)) for stage, count in aimed for _ in range(count * kills // 100)
    ]
    spread = kills - len(aims)
    aims += [("wall time", (number + 0.5) / spread) for number in range(spread)]
    draw.shuffle(aims)
    return aims


def one_kill(
    number: int,
    aim: str,
    moment_s: float,
    *,
    folder: Path,
    environment: dict[str, str],
    wanted: dict[str, str],
) -> Kill:
    """Start, kill, go on, compare."""
    notes = []
    fresh(folder)
    if aim == "compilation":  # caches of this kill's own, empty at first
        cache = folder / "caches"
        environment = {
            **environment,
            "POCL_CACHE_DIR": str(cache / "pocl"),
            "XDG_CACHE_HOME": str(cache),
        }
        cache.joinpath("pocl").mkdir(parents=True)
    victim = VICTIMS[number % len(VICTIMS)]
    with (folder / "killed.log").open("w") as log:
        start = time.monotonic()
        running = psutil.Popen(
            SNAKEMAKE, cwd=folder, env=environment, stdout=log, stderr=log, start_new_session=True
        )
        jobs = wait_for(running, aim=aim, moment_s=moment_s, victim=victim)
        at_s = time.monotonic() - start
        ran = "+".join(sorted({stage_of(job) for job in jobs})) or "snakemake alone"
        if running.poll() is not None:  # it was faster than the undisturbed run: earlier, then
            return one_kill(
                number, aim, 0.7 * moment_s, folder=folder, environment=environment, wanted=wanted
            )
        if victim == "group":
            os.killpg(running.pid, signal.SIGKILL)
        elif victim == "snakemake":
            running.kill()
        elif jobs:
            with contextlib.suppress(psutil.NoSuchProcess):
                jobs[0].kill()
        else:
            notes.append("no job to kill")
        try:
            status = running.wait(PATIENCE_S)
            if victim == "job":
                notes.append(f"snakemake ended with {status}")
        except psutil.TimeoutExpired:
            notes.append("hung")
            os.killpg(running.pid, signal.SIGKILL)
            running.wait()
    begin = time.monotonic()
    with (folder / "resumed.log").open("w") as log:
        resumed = resume(folder, environment, log)
    remade_s = time.monotonic() - begin
    found = digests(folder)
    different = sorted(path for path in wanted | found if wanted.get(path) != found.get(path))
    notes += [f"differs: {' '.join(different[:5])}"] if different else []
    lost = [path for path, sha256 in found.items() if traces(folder).get(path) != sha256]
    notes += [f"on no card: {' '.join(lost[:5])}"] if lost else []
    if not resumed or different or lost:
        shutil.copytree(folder, folder.with_name(f"{folder.name}-{number}"), dirs_exist_ok=True)
    return Kill(
        number=number,
        aim=aim,
        moment_s=round(at_s, 2),
        ran=ran,
        killed=victim,
        resumed=resumed,
        digests_equal=not different,
        traced=not lost,
        remade_s=round(remade_s, 1),
        note="; ".join(notes),
    )


def resume(folder: Path, environment: dict[str, str], log: IO[str]) -> bool:
    """Go on as `make resume` does; whether all went well."""

    def run(*command: str, **more: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            command,
            cwd=folder,
            env=environment,
            stderr=log,
            text=True,
            timeout=PATIENCE_S,
            **more,
        )

    try:
        if run(*LIBRARY, "unlock", stdout=log).returncode:
            return False
        repair = run(*LIBRARY, "repair", stdout=subprocess.PIPE)
        damaged = ["--forcerun", *repair.stdout.split()] if repair.stdout else []
        again = run(*SNAKEMAKE, "--rerun-incomplete", *damaged, stdout=log)
    except subprocess.TimeoutExpired:
        log.write("hung\n")
        return False
    return repair.returncode == again.returncode == 0


def wait_for(
    running: psutil.Popen, *, aim: str, moment_s: float, victim: str
) -> list[psutil.Process]:
    """Wait for the moment of the kill; the jobs that run then."""
    start = time.monotonic()
    if aim not in STAGES.values():
        with contextlib.suppress(psutil.TimeoutExpired):
            running.wait(moment_s)
        while not (jobs := jobs_of(running)) and victim == "job" and running.poll() is None:
            time.sleep(0.01)
        return jobs
    while running.poll() is None and time.monotonic() - start < PATIENCE_S:
        if any(stage_of(job) == aim for job in jobs_of(running)):
            break
        time.sleep(0.01)
    while moment_s > 0 and running.poll() is None:
        jobs = [job for job in jobs_of(running) if stage_of(job) == aim]
        if not jobs:  # it was shorter than that: the next one of its kind
            return wait_for(running, aim=aim, moment_s=moment_s / 2, victim=victim)
        time.sleep(min(0.02, moment_s))
        moment_s -= 0.02
    jobs = jobs_of(running)
    return sorted(jobs, key=lambda job: stage_of(job) != aim)


def jobs_of(running: psutil.Process) -> list[psutil.Process]:
    """The library's processes below snakemake."""
    try:
        return [job for job in running.children(recursive=True) if stage_of(job)]
    except psutil.NoSuchProcess:
        return []


def stage_of(job: psutil.Process) -> str:
    """What a process of the library does; empty for other processes."""
    try:
        words = job.cmdline()
    except psutil.Error:
        return ""
    if len(words) < 4 or not Path(words[0]).name.startswith("python"):
        return ""
    if words[1] != "-m" or words[2] not in PACKAGES:
        return ""
    command = words[3]
    return STAGES.get(command, command)


def fresh(folder: Path) -> None:
    """A copy of the checkout in which nothing has been made."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("results", "logs", "benchmarks", ".snakemake", "caches"):
        shutil.rmtree(folder / name, ignore_errors=True)
    for name in PARTS:
        if not (folder / name).exists():
            source = CHECKOUT / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, folder / name)


def digests(folder: Path) -> dict[str, str]:
    """Every file that jobs made, but for run times, with its digest."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.glob("results/**/*"))
        if path.is_file()
        and not {"run_cards", "basis", "study.yaml"} & set(path.parts)  # the run's own
        and "timings" not in path.name
    }


def traces(folder: Path) -> dict[str, str]:
    """The digest of each file on the newest card that names it."""
    jobs = []
    for path in sorted(folder.glob("results/quick/run_cards/*.json")):
        jobs += json.loads(path.read_text())["jobs"]
    return {
        name: sha256
        for job in sorted(jobs, key=lambda job: job["ended"])
        for name, sha256 in job["files"].items()
    }


def summary(kills: list[Kill]) -> str:
    """The kills in a few lines."""
    ran = Counter(stage for kill in kills for stage in kill.ran.split("+"))
    lines = [f"{len(kills)} kills", f"killed: {dict(Counter(kill.killed for kill in kills))}"]
    lines.append(f"running at that moment: {dict(ran.most_common())}")
    for name in ("resumed", "digests_equal", "traced"):
        lines.append(f"{name}: {sum(getattr(kill, name) for kill in kills)}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())

"""Whatever stops a run, going on as `make resume` does ends with the same results.

Each test says a fault, what the user is told, and that the results are the same afterwards. The
stage is `make test-faults`; kill_many.py kills a run a hundred times.
"""

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import pytest

from . import kill_many
from .kill_many import LIBRARY, SNAKEMAKE, digests, fresh, jobs_of, stage_of

FORCES = "results/quick/simulations/screen/forces.csv"
FIT = "results/quick/fits/screen.json"


@dataclass
class Checkout:
    """A copy of the checkout in which a part of the quick study is made."""

    folder: Path
    wanted: dict[str, str] = field(default_factory=dict)

    @property
    def environment(self) -> dict[str, str]:
        return {**os.environ, "PYTHONPATH": str(self.folder / "workflow")}

    def run(self, *command: str) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        assert "Traceback" not in done.stdout, done.stdout
        return done

    def snakemake(self) -> subprocess.CompletedProcess[str]:
        return self.run(*SNAKEMAKE)

    def resume(self) -> str:
        """Go on as `make resume` does; what was printed."""
        path = self.folder / "resumed.log"
        with path.open("w") as log:
            done = kill_many.resume(self.folder, self.environment, log)
        told = path.read_text()
        assert done, told
        return told

    def start(self) -> psutil.Popen:
        with (self.folder / "started.log").open("w") as log:
            return psutil.Popen(
                SNAKEMAKE,
                cwd=self.folder,
                env=self.environment,
                stdout=log,
                stderr=log,
                start_new_session=True,
                # Whatever runs these tests in the background may have ignored it for all below.
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
            )

    def same(self) -> bool:
        left = [path for path in self.folder.glob("results/**/.*") if path.name != ".gitkeep"]
        found = {
            name: value for name, value in digests(self.folder).items() if ".damaged" not in name
        }
        return found == self.wanted and not left


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    """A finished run."""
    checkout = Checkout(tmp_path_factory.mktemp("undisturbed"))
    fresh(checkout.folder)
    done = checkout.snakemake()
    assert done.returncode == 0, done.stdout
    checkout.wanted = digests(checkout.folder)
    return checkout


@pytest.fixture
def checkout(undisturbed, tmp_path):
    """A checkout in which nothing has been made yet."""
    fresh(tmp_path)
    return Checkout(tmp_path, undisturbed.wanted)


@pytest.fixture
def finished(undisturbed, tmp_path):
    """A copy of a finished run, its files' times kept."""
    shutil.copytree(undisturbed.folder, tmp_path, dirs_exist_ok=True)
    return Checkout(tmp_path, undisturbed.wanted)


def wait_for_job(running: psutil.Popen, stage: str) -> psutil.Process:
    while running.poll() is None:
        for job in jobs_of(running):
            if stage_of(job) == stage:
                return job
        time.sleep(0.005)
    pytest.fail(f"ended before anything of {stage}: {running.returncode}")


@pytest.mark.parametrize(
    ("number", "aim"), [(0, "plotting"), (1, "fit"), (2, "simulation")], ids=kill_many.VICTIMS
)
def test_a_killed_run_goes_on(checkout, number, aim):
    kill = kill_many.one_kill(
        number,
        aim,
        0.1,
        folder=checkout.folder,
        environment=checkout.environment,
        wanted=checkout.wanted,
    )
    assert aim in kill.ran
    assert kill.killed == kill_many.VICTIMS[number]
    assert (kill.resumed, kill.digests_equal, kill.traced) == (True, True, True), kill
    assert "Nothing to be done" in checkout.snakemake().stdout


def test_a_second_run_is_refused_while_the_first_goes_on(checkout):
    first = checkout.start()
    wait_for_job(first, "simulation")
    os.killpg(first.pid, signal.SIGSTOP)  # or it might be done before the others have looked
    for command, status in (
        (SNAKEMAKE, 1),
        ((*SNAKEMAKE, "--nolock"), 2),
        ((*LIBRARY, "unlock"), 1),
    ):
        second = checkout.run(*command)
        assert second.returncode == status
        assert f"results/quick is being made by process {first.pid} on " in second.stdout
        assert "wait for it, or end it" in second.stdout
    assert "left alone" in checkout.run(*LIBRARY, "repair").stdout
    os.killpg(first.pid, signal.SIGCONT)
    assert first.wait() == 0
    assert checkout.same()


OLD_CODE = """

right = write_json


def write_json(values, path):
    import time
    from pathlib import Path

    Path("waiting").touch()
    while not Path("go").exists():
        time.sleep(0.01)
    right({**values, "theta": [0.0, 0.0, 0.0]}, path)
"""


def test_a_job_that_outlives_its_run_does_not_spoil_the_next_one(checkout):
    """The code is mended after the kill: what the old job writes last is of the old code."""
    code = checkout.folder / "workflow/squeezefilm/cli/steps/fit.py"
    right = code.read_text()
    code.write_text(right + OLD_CODE)
    running = checkout.start()
    old_job = wait_for_job(running, "fit")
    while not (checkout.folder / "waiting").exists():
        time.sleep(0.01)
    running.kill()
    running.wait()
    code.write_text(right)
    try:
        checkout.resume()
        assert checkout.same()
    finally:
        (checkout.folder / "go").touch()
        psutil.wait_procs([old_job], timeout=60)
    assert not old_job.is_running()
    assert checkout.same()


@pytest.fixture
def mount(tmp_path):
    """Mount a small file system on a folder, or change its options."""
    mounted: list[Path] = []

    def mount(folder: Path, options: str, *, again: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        options = f"remount,{options}" if again else options
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            pytest.skip("there is no mount command for a small disk to fill")
        if done.returncode:
            pytest.skip(f"a small disk to fill cannot be mounted: {done.stderr.strip()}")
        mounted.append(folder)

    yield mount
    for folder in dict.fromkeys(mounted):
        subprocess.run(["umount", str(folder)], check=True)


def test_a_full_disk_is_told_and_then_made_room(checkout, mount):
    results = checkout.folder / "results"
    mount(results, "size=850k")  # what results rest on takes 750 of it
    done = checkout.snakemake()
    assert done.returncode != 0
    assert "cannot be written: No space left on device" in done.stdout
    made = digests(checkout.folder)
    assert made
    assert made.items() <= checkout.wanted.items()
    mount(results, "size=50m", again=True)
    checkout.resume()
    assert checkout.same()


@pytest.mark.parametrize(
    ("options", "reason"),
    [("size=4k", "No space left on device"), ("size=50m,ro", "Read-only file system")],
)
def test_a_disk_that_takes_nothing_is_told_before_anything_runs(checkout, mount, options, reason):
    mount(checkout.folder / "results", options)
    done = checkout.snakemake()
    assert done.returncode == 2
    assert f"cannot be written: {reason}" in done.stdout
    assert "Compile the kernels" not in done.stdout
    mount(checkout.folder / "results", "size=50m,rw", again=True)
    checkout.resume()
    assert checkout.same()


def test_a_file_where_the_results_should_be_is_told(checkout):
    (checkout.folder / "results").mkdir()
    (checkout.folder / "results/quick").write_text("")
    done = checkout.snakemake()
    assert done.returncode == 2
    assert "results/quick is a file; the results are to be in a folder" in done.stdout


def test_a_folder_where_a_result_should_be_is_found(finished):
    fit = finished.folder / FIT
    fit.unlink()
    fit.mkdir()
    (fit / "something").write_text("")
    assert f"{FIT} is not as it was made" in finished.resume()
    assert (finished.folder / f"{FIT}.damaged/something").exists()
    assert finished.same()


def truncate(path: Path, size: int) -> None:
    os.truncate(path, size)


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "a row cut": lambda data: data[:-40],
    "rows lost": lambda data: b"".join(data.splitlines(keepends=True)[:6]),
    "empty": lambda data: b"",
    "zeros": lambda data: bytes(len(data)),
    "a digit changed": lambda data: data.replace(b"e-06,", b"e-05,", 1),
}
TOLD = {
    "a row cut": f"{FORCES}: line 13: ",
    "empty": f"{FORCES}: the table is empty",
    "zeros": f"{FORCES}: ",
}


@pytest.mark.parametrize("damage", TOLD)
def test_a_damaged_table_is_named(finished, damage):
    path = finished.folder / FORCES
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    output = ["--output", "x.json", "--runs", "x.csv"]
    told = finished.run(
        *LIBRARY, "fit", FORCES, "--model", "two-factor", "--config", "config/quick.yaml", *output
    )
    assert told.returncode == 2
    assert f"squeezefilm: error: {TOLD[damage]}" in told.stdout


def test_damaged_results_are_found_and_made_anew(finished):
    """Tables of every damage, and other kinds of files; the files' times say nothing of it."""
    results = finished.folder / "results/quick"
    (chunk,) = results.glob("simulations/screen/chunks/*-of-1.csv")
    files = {
        results / "simulations/screen/scenes.csv": "a digit changed",
        results / "simulations/device.json": "zeros",
        results / "simulations/screen/forces.csv": "rows lost",
        chunk: "rows lost",
        results / "fits/screen.json": "a row cut",
        results / "figures/fig08.csv": "empty",
        results / "figures/fig07.png": "zeros",
    }
    for path, damage in files.items():
        data, times = path.read_bytes(), path.stat()
        assert DAMAGES[damage](data) != data
        path.write_bytes(DAMAGES[damage](data))
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    told = finished.resume()
    for path in files:
        assert f"{path.name} is not as it was made" in told
    assert finished.same()
    assert "Nothing to be done" in finished.snakemake().stdout


def test_a_damaged_record_of_snakemake_does_no_harm(finished):
    """Snakemake writes its own records in place: a kill can leave half of one."""
    for path in (finished.folder / ".snakemake/metadata").iterdir():
        truncate(path, path.stat().st_size // 2)
    finished.resume()
    assert finished.same()


def test_a_result_is_traced_to_its_run(finished):
    copy = finished.folder / "from_a_colleague.csv"
    shutil.copy(finished.folder / FORCES, copy)
    told = finished.run(*LIBRARY, "trace", FORCES).stdout
    for word in ("gather", "device", "driver", "(completed)", "config/quick.yaml", "run_cards/"):
        assert word in told
    assert finished.run(*LIBRARY, "trace", copy.name).returncode == 0
    copy.write_text(copy.read_text() + "\n")
    unknown = finished.run(*LIBRARY, "trace", copy.name)
    assert unknown.returncode == 1
    assert "no run in results made this file" in unknown.stdout


def test_an_interrupted_run_goes_on(checkout):
    running = checkout.start()
    wait_for_job(running, "fit")
    os.killpg(running.pid, signal.SIGINT)
    assert running.wait(60) != 0
    checkout.resume()
    assert checkout.same()

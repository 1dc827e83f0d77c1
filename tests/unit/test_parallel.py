"""Tasks on several processes come back whole and in order."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor

import psutil
import pytest

from squeezefilm.errors import InputError, RunError
from squeezefilm.parallel import parallel_map


@pytest.mark.parametrize("processes", [1, 3])
def test_results_are_those_of_a_plain_loop_in_order(processes):
    offset = 7
    results = parallel_map(lambda item: item * item + offset, range(20), processes=processes)
    assert results == [item * item + offset for item in range(20)]


def test_a_refusal_in_a_process_reaches_the_caller():
    def refuse(item: int) -> int:
        raise InputError(f"no {item}")

    with pytest.raises(InputError, match=r"no \d"):
        parallel_map(refuse, range(3), processes=2)


def test_a_process_that_is_killed_is_told_and_not_waited_for():
    def end(item: int) -> int:
        if item == 2:
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    with pytest.raises(RunError, match="was killed"):
        parallel_map(end, range(4), processes=2)


def test_processes_end_with_the_one_that_started_them(repository):
    code = (
        "import os, time; from squeezefilm.parallel import parallel_map\n"
        "task = lambda _: (os.write(1, b'%d\\n' % os.getpid()), time.sleep(60))\n"
        "parallel_map(task, [1, 2], processes=2)"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", code], cwd=repository / "workflow", stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout
    children = [int(parent.stdout.readline()) for _ in range(2)]
    parent.kill()
    parent.wait()
    parent.stdout.close()
    until = time.monotonic() + 5
    while time.monotonic() < until and any(map(psutil.pid_exists, children)):
        time.sleep(0.01)
    left = [child for child in children if psutil.pid_exists(child)]
    for child in left:
        os.kill(child, signal.SIGKILL)
    assert not left


def test_ctrl_c_is_not_lost_before_the_processes_are_there(monkeypatch):
    submit = ProcessPoolExecutor.submit

    def interrupted(pool: ProcessPoolExecutor, *task: object) -> object:
        os.kill(os.getpid(), signal.SIGINT)
        return submit(pool, *task)  # type: ignore[arg-type]

    monkeypatch.setattr(ProcessPoolExecutor, "submit", interrupted)
    with pytest.raises(KeyboardInterrupt):
        parallel_map(abs, range(3), processes=2)

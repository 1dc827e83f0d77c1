"""A command that takes long shows on stderr how far it is, on a terminal and in a log."""

import io
import re
import sys
import time

import pytest

from squeezefilm import parallel
from squeezefilm.cli.main import main


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
@pytest.mark.parametrize("command", ["simulate", "error-budget", "levitate"])
def test_a_command_on_one_scene_shows_how_far_it_is(monkeypatch, command, stream):
    monkeypatch.setattr(parallel, "PROGRESS_INTERVAL_S", 0.002)
    monkeypatch.setattr(sys, "stderr", stream())
    words = {"levitate": ["--load", "0.1 N", "--hv", "1um"]}
    given = words.get(command, ["--h0", "5um", "--hv", "2um"])
    assert main([command, *given]) == 0
    shown = sys.stderr.getvalue()
    assert re.search(rf"squeezefilm {command}: \d+ s; .*periodic states: \d+ of \d+ scenes", shown)
    if stream is Terminal:  # one line, cleared at the end
        assert "\n" not in shown
        assert shown.endswith("\r\033[K")
    else:
        assert "\r" not in shown


def test_quick_work_shows_nothing(monkeypatch, capsys):
    with parallel.show_progress("squeezefilm"), parallel.track_progress(2, unit="part", name="a"):
        time.sleep(0.01)
    assert capsys.readouterr().err == ""


def test_work_within_other_work_is_shown_in_order(monkeypatch, capsys):
    monkeypatch.setattr(parallel, "PROGRESS_INTERVAL_S", 0.01)
    with (
        parallel.show_progress("squeezefilm"),
        parallel.track_progress(4, unit="load", name="levitate") as loads,
        parallel.track_progress(1, unit="scene", name="solve"),
    ):
        loads.update(1)
        time.sleep(0.05)
    first = capsys.readouterr().err.splitlines()[0]
    assert first == "squeezefilm: 0 s; levitate: 1 of 4 loads; solve: 0 of 1 scenes"

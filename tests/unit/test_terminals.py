"""Terminals that are not in UTF-8 are shown substitutes, and never a traceback."""

import io
import os
import subprocess
import sys

import pytest

from squeezefilm.cli.main import main, modules_by_command
from squeezefilm.parallel import show_progress
from squeezefilm.terminals import enable_ascii_substitutes

ENCODINGS = ("ascii", "cp437", "cp932", "latin-1")
FORCE = ("simulate", "--h0", "5um", "--hv", "2.2um", "--tolerance", "1e-4")
PRINTED = {
    "--help": (0, "Forces, fields and fitted models"),
    " ".join(FORCE): (0, "operating point         h0 = 5 "),
    "config config/quick.yaml": (0, "study: quick"),
    "config config/ñandú-σ.yaml": (2, "there is no such configuration file"),
    "simulate --h0 5µm --hv 1°": (2, "must be a number with its unit: m, mm, um"),
    **{f"{command} --help": (0, "usage: squeezefilm") for command in modules_by_command()},
}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_every_command_prints_in_every_encoding(encoding, repository, monkeypatch):
    monkeypatch.chdir(repository)
    for words, (status, text) in PRINTED.items():
        terminal = io.TextIOWrapper(io.BytesIO(), encoding=encoding, write_through=True)
        monkeypatch.setattr("sys.stdout", terminal)
        monkeypatch.setattr("sys.stderr", terminal)
        try:
            ended = main(words.split())
        except SystemExit as end:
            ended = end.code
        told = terminal.buffer.getvalue().decode(encoding)
        assert (words, ended) == (words, status)
        assert text in told
        assert "Traceback" not in told


def test_substitutes_say_what_the_characters_say(monkeypatch):
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii", write_through=True)
    monkeypatch.setattr("sys.stdout", terminal)
    assert main(FORCE) == 0
    told = terminal.buffer.getvalue().decode("ascii")
    assert "numerical error         +/- " in told
    assert "operating point         h0 = 5 um, hv = 2.2 um, x = 0 m" in told
    assert " x 16 (x, y, time)" in told


def test_progress_is_shown_in_ascii(monkeypatch):
    monkeypatch.setattr("squeezefilm.parallel.PROGRESS_INTERVAL_S", 0.01)
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii", errors="strict")
    monkeypatch.setattr("sys.stderr", terminal)
    enable_ascii_substitutes(terminal)
    with show_progress("5 µm"):
        while b"5 um: " not in terminal.buffer.getvalue():
            pass


def test_a_locale_without_letters_beyond_ascii_has_forces():
    """Kernels' sources are in UTF-8 in every locale."""
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    told = subprocess.run(
        [sys.executable, "-m", "squeezefilm", *FORCE],
        env={**os.environ, **ascii_only},
        capture_output=True,
        timeout=120,
        check=False,
    )
    assert told.returncode == 0, told.stderr
    assert b"numerical error         +/- " in told.stdout

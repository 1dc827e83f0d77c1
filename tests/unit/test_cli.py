"""The command line speaks to its user: help, messages, exit statuses; never a traceback."""

import os
import subprocess
import sys
from math import nan
from pathlib import Path

import pandas as pd
import pytest

from squeezefilm.cli.main import main, modules_by_command
from squeezefilm.cli.options import print_table
from squeezefilm.errors import InputError, RunError
from squeezefilm.table_writer import concatenate_force_parts, write_table
from squeezefilm.tables import FORCE_COLUMNS, read_forces

COMMANDS = modules_by_command()


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert f"usage: squeezefilm {command}" in text
    assert len(text.splitlines()) > 8


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("simulat", "did you mean 'simulate'?"),
        ("zzzz", ""),
    ],
)
def test_a_typo_is_answered_with_the_nearest_command_alone(word, hint, capsys):
    with pytest.raises(SystemExit) as end:
        main([word])
    assert end.value.code == 2
    told = capsys.readouterr().err
    assert f"there is no command {word!r}; {hint}" in told
    others = [name for name in COMMANDS if f"'{name}'" in told]
    assert len(others) == (1 if hint else 0)
    assert len(told.splitlines()) == 2


def test_an_option_in_capitals_is_answered_with_the_small_one(capsys):
    with pytest.raises(SystemExit):
        main(["simulate", "--X", "1mm", "--h0", "5um", "--hv", "2um"])
    assert "did you mean '--x'?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ("simulate --gap 5um --hv 2um", "'--gap'; did you mean '--h0'?"),
        ("simulate --hO=5um --hv 2um", "'--hO=5um'; did you mean '--h0'?"),
        ("simulate --h0 5um --amplitude 2um", "'--amplitude'; did you mean '--hv'?"),
        ("simulate --h0 5um --hv 2um --out a.csv", "'--out'; did you mean '--output'?"),
        ("simulate --position 1mm --h0 5um", "'--position'; did you mean '--x' or '--y'?"),
        ("levitate --weight 1N --hv 2um", "'--weight'; did you mean '--load' or '--mass'?"),
        ("amplitude-for FIT.json --load 1N", "'--load'; did you mean '--force'?"),
        (
            "levitate --h0 18um --load 1N --hv 2um",
            "'--h0'; `squeezefilm levitate` finds the gap; for a given gap use `squeezefilm "
            "simulate`;",
        ),
        (
            "levitate --load 1N --hv 2um --outputs power",
            "'--outputs'; `squeezefilm simulate --outputs` computes further quantities at a given "
            "gap;",
        ),
    ],
)
def test_an_option_by_another_name_is_answered_with_its_own(words, hint, capsys):
    with pytest.raises(SystemExit) as end:
        main(words.split())
    assert end.value.code == 2
    assert f"takes no {hint} `squeezefilm" in capsys.readouterr().err


def part(path: Path, *ids: str, status: str = "ok") -> Path:
    rows = [
        dict.fromkeys(FORCE_COLUMNS, 1) | {"point_id": name, "status": status, "force_n": 0.5}
        for name in ids
    ]
    write_table(pd.DataFrame(rows), path)
    return path


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "scenes.csv"
    rows = [
        {"point_id": str(n), "h0_m": 1, "hv_m": 1, "phi_r_m": 1, "phi_deg": 1} for n in (1, 2, 3)
    ]
    write_table(pd.DataFrame(rows), path)
    return path


def test_a_failed_scene_is_named_and_nothing_written(plan, tmp_path):
    parts = [part(tmp_path / "a.csv", "1"), part(tmp_path / "b.csv", "2", "3", status="no end")]
    output = tmp_path / "forces.csv"
    with pytest.raises(RunError, match=r"point 3: no end \(.*b\.csv\)"):
        concatenate_force_parts(plan, parts, output=output, keep_failed=False)
    assert not output.exists()
    concatenate_force_parts(plan, parts, output=output, keep_failed=True)
    assert list(read_forces(output)["status"]) == ["ok", "no end", "no end"]


@pytest.mark.parametrize("ids", ["2", "12", "24"])
def test_parts_that_do_not_make_the_plan_are_refused(ids, plan, tmp_path):
    parts = [part(tmp_path / "a.csv", "1"), part(tmp_path / "b.csv", *ids)]
    with pytest.raises(InputError, match=r"b\.csv: its points are not those of part 2 of 2"):
        concatenate_force_parts(plan, parts, output=tmp_path / "forces.csv", keep_failed=False)


def test_doctor_fails_without_a_device_and_says_how_to_mend_it(tmp_path, refused, monkeypatch):
    monkeypatch.setenv("SQUEEZEFILM_DEVICE", "no such device")
    text = refused("doctor", status=1)
    assert "name one of these, or `auto`" in text
    assert "SQUEEZEFILM_DEVICE" in text


THREADS_OF_A_COMMAND = """
import os
from squeezefilm.cli.main import main
try:
    main(["simulate", "--help"])
except SystemExit:
    pass
import numpy as np
np.linalg.eigh(np.eye(300))
print(len(os.listdir("/proc/self/task")))
"""


@pytest.mark.skipif(sys.platform != "linux" or os.cpu_count() == 1, reason="counts threads")
def test_linear_algebra_of_a_command_takes_one_thread_unless_it_is_told():
    for threads, expected in ((None, "1"), ("2", "2")):
        environment = {
            name: each for name, each in os.environ.items() if "_NUM_THREADS" not in name
        }
        environment["PYTHONPATH"] = os.pathsep.join(map(str, sys.path))
        if threads:
            environment["OPENBLAS_NUM_THREADS"] = threads
        command = [sys.executable, "-c", THREADS_OF_A_COMMAND]
        run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        assert run.stdout.split()[-1] == expected


@pytest.mark.parametrize(
    "command", ["levitate --load 1N", "simulate --h0 5um", "response --h0 5um"]
)
def test_a_table_of_another_format_is_refused_before_anything_is_solved(
    command, monkeypatch, refused, tmp_path
):
    monkeypatch.setattr("squeezefilm.api.film.Film.scenes", None)
    words = [*command.split(), "--hv", "1um", "--output"]
    assert "x.xlsx: a table is written as .csv" in refused(*words, tmp_path / "x.xlsx")
    assert "-: a table is written to a file; give its name" in refused(*words, "-")


def test_a_row_without_a_name_is_called_by_its_line(tmp_path, refused):
    path = tmp_path / "scenes.csv"
    path.write_text("h0_um,hv_um\n5,2\n5,6\n")
    told = refused("simulate", path, "--output", tmp_path / "forces.csv")
    assert f"error: {path}: line 3: hv = 6 µm reaches h0 = 5 µm" in told


def test_a_printed_table_has_errors_beside_values_and_notes_in_the_order_of_rows(capsys):
    table = pd.DataFrame(
        {
            "h0_m": [1e-5, 2e-5, 3e-5],
            "force_n": [0.52, 0.1, nan],
            "force_error_n": [8e-5, nan, nan],
            "status": ["ok", "ok", "not converged"],
            "validity": ["ok", "Re is large", "ok"],
        }
    )
    print_table(table)
    header, first, second, third, *notes = capsys.readouterr().out.splitlines()
    assert header.split() == ["h0_m", "force_n", "status", "validity"]
    assert "0.520000 ± 8.0e-05" in first
    assert "0.1 ± unknown" in second
    assert "±" not in third
    assert [" ".join(note.split()) for note in notes] == [
        "note row 2: Re is large",
        "row 3: not converged",
    ]

"""Tasks on several processes come back whole and in order."""

from __future__ import annotations

import os

import pytest

from squeezefilm.errors import InputError
from squeezefilm.parallel import spread


@pytest.mark.parametrize("processes", [1, 3])
def test_results_are_those_of_a_plain_loop_in_order(processes: int) -> None:
    offset = 7
    results = spread(lambda item: item * item + offset, range(20), processes=processes)
    assert results == [item * item + offset for item in range(20)]


def test_several_processes_share_the_work() -> None:
    assert os.getpid() not in spread(lambda _: os.getpid(), range(4), processes=2)


def test_a_refusal_in_a_process_reaches_the_caller() -> None:
    def refuse(item: int) -> int:
        raise InputError(f"no {item}")

    with pytest.raises(InputError, match=r"no \d"):
        spread(refuse, range(3), processes=2)

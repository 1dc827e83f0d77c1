"""A processor that PoCL's compiler does not know is compiled for by what it can do."""

import ctypes
import sys

import pytest

from squeezefilm.reynolds.device import (
    FLAGS_OF_INSTRUCTION_SET,
    instruction_set_level,
    patch_pocl_processor_name,
)

ALL = frozenset().union(*FLAGS_OF_INSTRUCTION_SET.values())

linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


def test_level_is_the_highest_of_which_nothing_lacks():
    assert instruction_set_level(frozenset()) == "x86-64"
    assert instruction_set_level(ALL) == "x86-64-v4"
    assert instruction_set_level(ALL - {"avx512vl"}) == "x86-64-v3"
    assert instruction_set_level(ALL - {"fma"}) == "x86-64-v2"


def record(*texts: bytes) -> ctypes.Array:
    """Numbers that are no addresses, and pointers to texts."""
    buffers = [ctypes.create_string_buffer(text) for text in texts]
    record = (ctypes.c_uint64 * 200)(1, 2**64 - 1, 12345, *(map(ctypes.addressof, buffers)))
    record.texts = buffers  # type: ignore[attr-defined]
    return record


@linux
def test_the_pointer_to_the_unknown_name_is_the_one_that_changes():
    there = record(b"pthread", b"generic", b"generic-not")
    before = list(there)
    assert patch_pocl_processor_name(ctypes.addressof(there), "x86-64-v3")
    changed = [place for place in range(200) if there[place] != before[place]]
    assert changed == [4]
    assert ctypes.string_at(there[4]) == b"x86-64-v3"


@linux
def test_a_record_without_it_is_left_alone():
    there = record(b"znver3")
    before = list(there)
    assert not patch_pocl_processor_name(ctypes.addressof(there), "x86-64-v3")
    assert list(there) == before

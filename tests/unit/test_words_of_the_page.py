"""The explorer says numbers as the command line does (words.js beside units.py)."""

import json
import shutil
import subprocess

import pytest

from squeezefilm.units import to_its_error

NODE = shutil.which("node")
# A value and its error, in the page's units.
SAID = [(0.962042, 6e-7), (0.9613, 0.0031), (-3.26, 0.4), (42.4, 3.0), (1234.0, 20.0)]


@pytest.mark.skipif(NODE is None, reason="no node here")
def test_the_page_gives_a_value_the_digits_of_its_error(repository) -> None:
    words = (repository / "workflow/reporting/explorer/words.js").read_text(encoding="utf-8")
    said = f"{json.dumps(SAID)}.map((each) => toItsError(...each))"
    program = f"{words}; console.log(JSON.stringify({said}))"
    told = subprocess.run(
        [NODE, "-e", program], capture_output=True, text=True, check=True, timeout=60
    ).stdout
    for (value, error), (digits, around) in zip(SAID, json.loads(told), strict=True):
        expected, expected_error = to_its_error(value, error)
        assert float(digits.replace("−", "-")) == float(expected)
        assert float(around) == float(expected_error)

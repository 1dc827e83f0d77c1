"""The pages about the library's names are made from docstrings, without a network."""

import re
import subprocess
import sys

import squeezefilm as sf


def test_every_name_has_its_place_on_a_page_that_needs_no_network(repository, tmp_path):
    makefile = (repository / "Makefile").read_text(encoding="utf-8")
    (recipe,) = re.findall(r"pdoc (.*) --output-directory \$\(API\) squeezefilm", makefile)
    words = [*recipe.split(), "--output-directory", str(tmp_path), "squeezefilm"]
    done = subprocess.run(
        [sys.executable, "-m", "pdoc", *words], capture_output=True, text=True, check=True
    )
    assert "Warn" not in done.stderr
    page = (tmp_path / "squeezefilm.html").read_text(encoding="utf-8")
    for name in sf.__all__:
        assert f'id="{name}"' in page
    for method in ("force", "curve", "pressure", "of", "scene"):
        assert f'id="Film.{method}"' in page
    assert not re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="https?://', page)

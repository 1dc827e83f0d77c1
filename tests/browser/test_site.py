"""The documentation's pages on a desktop and on a phone, opened from the disk."""

import subprocess
import sys

import pytest

from squeezefilm import __version__

DESKTOP, PHONE = (1300, 900), (400, 800)
# Wait for the formulas, if any.
TYPESET = """
const done = arguments[0], formulas = window.MathJax?.startup?.promise;
formulas ? formulas.then(done) : setTimeout(done, document.querySelector(".math") ? 1500 : 0);
"""
# Formulas as text, tables and printed lines that are wider than their place, and names of tables
# that are broken within: the keys of the configuration stood in a column of 60 pixels.
FAULTS = r"""
const cut = [...document.querySelectorAll("article .table-wrapper, article pre, article img")]
  .filter((part) => part.scrollWidth > part.clientWidth + 1);
const broken = [...document.querySelectorAll("article td code")]
  .filter((name) => /^[\w.]+$/.test(name.textContent) && name.getClientRects().length > 1);
return [
  [...document.querySelectorAll(".math")].filter((part) => /\\[(\[]/.test(part.textContent)).length,
  cut.map((part) => part.innerText.slice(0, 60)),
  cut.filter((part) => part.closest("#keys, #columns-of-the-tables")).length,
  broken.map((name) => name.textContent),
];
"""


@pytest.fixture(scope="session")
def site(repository):
    """The pages as `make docs` makes them; what is made already stays."""
    folder = repository / "docs/_build/html"
    words = ["-q", "-W", "--keep-going", "-b", "html", str(repository / "docs"), str(folder)]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=str)
def test_no_page_is_wider_than_the_window_or_needs_a_network(size, browser, site):
    pages = [page for page in site.rglob("*.html") if not page.name.startswith(("gen", "py-"))]
    assert len(pages) > 25
    faults = {}
    for page in pages:
        requests = browser.open(page, size=size)
        browser.driver.execute_async_script(TYPESET)
        requests += browser.requests()
        elsewhere = [each["url"] for each in requests if not each["url"].startswith("file:")]
        raw, cut, cut_references, broken = browser.run(FAULTS)
        wide = browser.run("return document.documentElement.scrollWidth > innerWidth")
        # A phone's tables scroll, but for keys and columns, whose meaning stands last.
        found = (elsewhere, raw, wide, broken, cut if size == DESKTOP else cut_references)
        if any(found):
            faults[page.relative_to(site)] = found
    assert faults == {}


def test_the_home_page_says_what_it_is_how_to_begin_and_where_to_go(browser, site):
    browser.open(site / "index.html", size=DESKTOP)
    assert __version__ in browser.run("return document.title")
    text = browser.run("return document.querySelector('article').innerText")
    for words in ("mean force of a squeeze film", "make paper", "$ squeezefilm simulate"):
        assert words in text
    pictures = browser.run(
        "return [...document.querySelectorAll('.gallery a')].filter((a) => a.querySelector('img'))"
        ".map((a) => [a.href, a.querySelector('img').naturalWidth])"
    )
    assert len(pictures) >= 4
    for address, width in pictures:
        assert address.startswith(site.as_uri())
        assert width > 300
    browser.open(site / "about.html", size=DESKTOP)
    text = browser.run("return document.querySelector('article').innerText")
    assert "@software{squeezefilm" in text
    assert f"version = {{{__version__}}}" in text
    assert "MIT License" in text


def test_the_notebook_is_a_page_with_its_pictures_and_numbers(browser, site):
    browser.open(site / "notebook.html", size=DESKTOP)
    assert browser.run("return document.querySelectorAll('.cell_output img').length") == 2
    assert "0.96204" in browser.run("return document.querySelector('article').innerText")

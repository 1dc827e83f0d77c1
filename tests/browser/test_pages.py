"""Pages open from the disk, on any width, without a word to a server or on the console."""

import pytest

from .conftest import DESKTOP, PAGES, PHONE, SMALL_PHONE

# Names in the list that are wider than it, and empty shares of the card of controls.
CONTROLS = """
const list = document.getElementById("fit");
const pen = document.createElement("canvas").getContext("2d");
pen.font = getComputedStyle(list).font;
const card = document.querySelector(".controls").getBoundingClientRect();
const rows = [...document.querySelectorAll(".row")].map((row) => row.getBoundingClientRect())
  .filter((row) => row.height);
return [[...list.options].map((o) => o.text)
  .filter((text) => pen.measureText(text).width > list.clientWidth - 34),
  Math.max(rows[0].top - card.top, card.bottom - rows.at(-1).bottom) / card.height];
"""


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("size", [PHONE, SMALL_PHONE, DESKTOP], ids=str)
def test_a_page_opens_from_the_disk_as_wide_as_the_window_and_asks_for_nothing_else(
    page, size, browser, results
):
    path = results / f"{page}.html"
    requests = browser.open(path, size=size)
    assert [each["url"] for each in requests] == [path.as_uri()]
    assert browser.complaints() == []
    assert browser.run("return document.title")
    assert browser.run("return document.documentElement.lang").startswith("en")
    assert browser.run("return document.querySelectorAll('h1').length") >= 1
    wide = browser.run("return document.documentElement.scrollWidth")
    assert wide <= browser.run("return innerWidth") == size[0]
    cut, empty = browser.run(CONTROLS) if page == "explorer" else ([], 0)
    assert cut == []
    assert empty < 0.1


def test_the_summary_opens_with_its_pictures_each_with_a_conclusion(browser, results):
    browser.open(results / "report/summary.html", size=PHONE)
    pictures = browser.run(
        "return [...document.querySelectorAll('h1 + .pictures li')].map((li) => "
        "[li.innerText, li.querySelector('img').alt, li.querySelector('img').naturalWidth])"
    )
    assert len(pictures) == 5
    for text, alt, width in pictures:
        assert text.endswith(".")
        assert len(alt) > 30
        assert width > 900

"""Both pages open from the disk, on any width, without a word to a server or on the console."""

import pytest
from matplotlib.image import imread

from .conftest import DESKTOP, PAGES, PHONE, SMALL_PHONE, page_of


@pytest.mark.parametrize("page", PAGES)
def test_a_page_opens_from_the_disk_and_asks_for_nothing_else(page, browser, results):
    path = page_of(results, page)
    requests = browser.open(path)
    assert [each["url"] for each in requests] == [path.as_uri()]
    assert browser.complaints() == []
    assert browser.run("return document.title")
    assert browser.run("return document.documentElement.lang").startswith("en")
    assert browser.run("return document.querySelectorAll('h1').length") >= 1


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("size", [PHONE, SMALL_PHONE, DESKTOP], ids=str)
def test_no_page_is_wider_than_the_window(page, size, browser, results):
    browser.open(page_of(results, page), size=size)
    wide = browser.run("return document.documentElement.scrollWidth")
    assert wide <= browser.run("return innerWidth") == size[0]


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize(
    ("name", "size", "dark"),
    [("desktop", DESKTOP, False), ("dark", DESKTOP, True), ("phone", (PHONE[0], 2600), False)],
)
def test_a_page_shows_something(page, name, size, dark, browser, results):
    browser.open(page_of(results, page), size=size, dark=dark)
    picture = imread(browser.photograph(f"{page}-{name}"))[..., :3]
    assert picture.std() > 0.05
    # Every third of the window has something in it.
    third = len(picture) // 3
    assert min(picture[start : start + third].std() for start in (0, third, 2 * third)) > 0.01

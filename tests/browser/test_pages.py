"""Both pages open from the disk, on any width, without a word to a server or on the console."""

import pytest

from .conftest import DESKTOP, PAGES, PHONE, SMALL_PHONE


@pytest.mark.parametrize("page", PAGES)
def test_a_page_opens_from_the_disk_and_asks_for_nothing_else(page, browser, results):
    path = results / f"{page}.html"
    requests = browser.open(path)
    assert [each["url"] for each in requests] == [path.as_uri()]
    assert browser.complaints() == []
    assert browser.run("return document.title")
    assert browser.run("return document.documentElement.lang").startswith("en")
    assert browser.run("return document.querySelectorAll('h1').length") >= 1


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("size", [PHONE, SMALL_PHONE, DESKTOP], ids=str)
def test_no_page_is_wider_than_the_window(page, size, browser, results):
    browser.open(results / f"{page}.html", size=size)
    wide = browser.run("return document.documentElement.scrollWidth")
    assert wide <= browser.run("return innerWidth") == size[0]

"""The report opens its pages and figures from within itself."""

from typing import Any

import pytest
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from .conftest import LONGEST_WAIT_S, Browser


class Report:
    """Snakemake's report, by what a reader clicks."""

    def __init__(self, browser: Browser) -> None:
        self.driver = browser.driver
        # A row that is drawn anew while it is read is read again.
        again = (StaleElementReferenceException,)
        self.wait = WebDriverWait(self.driver, LONGEST_WAIT_S, ignored_exceptions=again)

    def categories(self) -> list[str]:
        links = self.wait.until(lambda d: d.find_elements(By.CSS_SELECTOR, "a"))
        return [link.text for link in links if link.text[:1].isdigit()]

    def click(self, name: str) -> None:
        self.wait.until(lambda d: d.find_elements(By.LINK_TEXT, name))[0].click()

    def rows(self) -> list[Any]:
        return self.wait.until(lambda d: d.find_elements(By.CSS_SELECTOR, "tbody tr"))

    def show(self, words: str) -> None:
        """Press the eye beside a result."""
        [row] = self.wait.until(lambda d: [row for row in self.rows() if words in row.text])
        row.find_element(By.CSS_SELECTOR, "[iconname=eye]").click()


@pytest.fixture
def report(browser, results):
    browser.open(results / "report.html")
    yield Report(browser)
    assert browser.complaints() == []
    assert browser.requests() == []


def test_the_first_page_is_the_headline_with_pictures_and_the_graph_comes_last(report):
    words = report.wait.until(lambda d: d.find_element(By.CSS_SELECTOR, ".prose"))
    assert "Study “quick”" in words.text
    assert "results of the paper agree" in words.text
    pictures = report.driver.find_elements(By.CSS_SELECTOR, ".prose .pictures img")
    assert len(pictures) == 5
    below = words.location["y"] + words.size["height"]
    assert report.driver.find_element(By.CSS_SELECTOR, "#rulegraph").location["y"] >= below


def test_a_figure_opens_inside_the_report(report):
    [category] = [name for name in report.categories() if "Figures" in name]
    report.click(category)
    report.show("Fig. 08")
    report.wait.until(
        lambda d: any(
            image.size["width"] > 200 and image.get_property("naturalWidth") > 200
            for image in d.find_elements(By.TAG_NAME, "img")
        )
    )

"""A real browser without a screen, and the pages of a study to open in it.

pytest tests/browser                             pages of the quick study, made first
pytest tests/browser --results results/paper     pages that are there already
"""

import json
import os
import shutil
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from ..workflow.conftest import QUICK, copy_checkout, snakemake

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PAGES = ("explorer", "report")
# What the report shows: the study without its numerics and most figures, which take their time.
SHOWN = ("explorer", "summary", "paper_tables", "fig08", "overview", "uncertainty")
# Drawing takes its time where a machine has much else to do.
LONGEST_WAIT_S = 120
DESKTOP, PHONE, SMALL_PHONE = (1280, 1200), (390, 844), (320, 640)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--results", type=Path, help="results of a study whose pages are to be judged")
    parser.addoption("--screenshots", type=Path, help="folder to keep pictures of the pages in")


@pytest.fixture(scope="session")
def results(request, repository, tmp_path_factory):
    """The results of a study that has its pages."""
    given = request.config.getoption("--results")
    if given:
        return Path(given).resolve()
    folder = copy_checkout(repository, tmp_path_factory.mktemp("pages") / "checkout")
    for report in ([], ["--report", "results/quick/report.html"]):
        done = snakemake(folder, *SHOWN, *report, *QUICK)
        assert done.returncode == 0, done.stdout[-6000:]
    return folder / "results/quick"


def page_of(results: Path, name: str) -> Path:
    """A page of a study; `make report` puts the report beside the studies."""
    inside = results / f"{name}.html"
    return inside if inside.exists() else results.parent / inside.name


@dataclass
class Browser:
    """Chromium, and what it said and asked for while a page was open."""

    driver: Any
    pictures: Path
    shown: tuple[Path, tuple[int, int], bool] | None = None

    def open(
        self, page: Path, *, size: tuple[int, int] = DESKTOP, dark: bool = False
    ) -> list[dict[str, Any]]:
        """Open a page from the disk; the requests made until it was drawn."""
        width, height = size
        self._emulate(
            "setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 500,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._emulate("setEmulatedMedia", features=[scheme])
        self.driver.get("about:blank")
        self.complaints()
        self.requests()
        self.driver.get(page.as_uri())
        self.settle()
        self.shown = (page, size, dark)
        return self.requests()

    def _emulate(self, command: str, **values: Any) -> None:
        self.driver.execute_cdp_cmd(f"Emulation.{command}", values)

    def settle(self) -> None:
        """Wait until what was asked for is drawn."""
        self.driver.execute_async_script(
            "const done = arguments[0];"
            "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50)))"
        )

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def complaints(self) -> list[str]:
        """Errors on the console since the last call."""
        log = self.driver.get_log("browser")
        return [entry["message"] for entry in log if entry["level"] == "SEVERE"]

    def requests(self) -> list[dict[str, Any]]:
        """Requests since the last call, those for parts of the page itself left out."""
        messages = (json.loads(e["message"])["message"] for e in self.driver.get_log("performance"))
        sent = [m["params"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        return [
            r["request"] for r in sent if not r["request"]["url"].startswith(("data:", "blob:"))
        ]

    def photograph(self, name: str) -> Path:
        """A picture of what is in the window."""
        self.pictures.mkdir(parents=True, exist_ok=True)
        path = self.pictures / f"{name}.png"
        assert self.driver.save_screenshot(str(path))
        return path


# Drawing in space needs WebGL, by software where there is no graphics card.
WITH_WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture(scope="session")
def browser(request, tmp_path_factory):
    with _started(request, tmp_path_factory, *WITH_WEBGL) as browser:
        yield browser


@pytest.fixture(scope="module")
def browser_without_webgl(request, tmp_path_factory):
    with _started(request, tmp_path_factory, "--disable-gpu", "--disable-3d-apis") as browser:
        yield browser


@contextmanager
def _started(request, tmp_path_factory, *words):
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    server = shutil.which("chromedriver")
    if program is None or server is None:
        pytest.skip(
            "no Chromium here: install Debian's chromium and chromium-driver, or their like"
        )
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for word in (
        "--headless=new",
        "--disable-dev-shm-usage",
        "--hide-scrollbars",
        *words,
        *(["--no-sandbox"] if os.geteuid() == 0 else []),
    ):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(server))
    driver.set_script_timeout(LONGEST_WAIT_S)
    pictures = request.config.getoption("--screenshots") or tmp_path_factory.mktemp("pictures")
    try:
        yield Browser(driver, pictures)
    finally:
        driver.quit()

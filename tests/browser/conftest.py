"""A real browser without a screen, and the pages of the quick study to open in it."""

import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from ..workflow.conftest import QUICK, copy_with_results, snakemake

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PAGES = ("explorer", "report", "report/summary", "report/claims")
# What the report shows: the study without its numerics and most figures, which take their time.
SHOWN = ("explorer", "summary", "paper_tables", "fig08", "overview", "uncertainty_table")
# Drawing takes its time where a machine has much else to do.
LONGEST_WAIT_S = 120
DESKTOP, PHONE, SMALL_PHONE = (1280, 1200), (390, 844), (320, 640)


@pytest.fixture(scope="session")
def results(repository, tmp_path_factory):
    """The results of a study that has its pages."""
    folder = copy_with_results(repository, tmp_path_factory.mktemp("pages") / "checkout")
    for report in ([], ["--report", "results/quick/report.html"]):
        done = snakemake(folder, *SHOWN, *report, *QUICK)
        assert done.returncode == 0, done.stdout[-6000:]
    return folder / "results/quick"


@dataclass
class Browser:
    """Chromium, and what it said and asked for while a page was open."""

    driver: Any
    in_shown_unit: Path | None = None

    def open(self, page: Path, *, size: tuple[int, int] = DESKTOP) -> list[dict[str, Any]]:
        """Open a page from the disk; the requests made until it was drawn."""
        width, height = size
        window = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", window)
        self.driver.get("about:blank")
        self.complaints()
        self.requests()
        self.driver.get(page.as_uri())
        self.settle()
        self.in_shown_unit = page if size == DESKTOP else None
        return self.requests()

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


# Drawing in space needs WebGL, by software where there is no graphics card.
WITH_WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture(scope="session")
def browser():
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
        *WITH_WEBGL,
        *(["--no-sandbox"] if os.geteuid() == 0 else []),
    ):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(server))
    driver.set_script_timeout(LONGEST_WAIT_S)
    try:
        yield Browser(driver)
    finally:
        driver.quit()

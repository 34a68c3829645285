"""Takes pictures of pages in both colour schemes and three widths."""

import re
import sys
from pathlib import Path
from typing import NamedTuple

from playwright.sync_api import Page, expect
from tests.browser.conftest import PATIENCE_MS

SIZES = {"wide": (1440, 1000), "tablet": (820, 1180), "phone": (390, 844)}
SCHEMES = ("light", "dark")
LIVE = re.compile("^live$")
BUSY = "main [aria-busy=true], main .mantine-Skeleton-root"
MAX_BYTES = 300_000


class Picture(NamedTuple):
    """A picture for the documents: which page, in which scheme, how large."""

    page: str
    scheme: str
    width: int
    height: int


DOCUMENTS = {
    "dashboard.png": Picture("overview", "light", 1440, 900),
    "dashboard-dark.png": Picture("overview", "dark", 1440, 900),
    "dashboard-tablet.png": Picture("overview", "light", 820, 1180),
    "dashboard-phone.png": Picture("overview", "dark", 390, 844),
    "robot.png": Picture("developer", "light", 1440, 1000),
    "goals.png": Picture("goals", "light", 1440, 800),
    "statistics.png": Picture("statistics", "light", 1440, 800),
    "goal.png": Picture("goal", "dark", 1440, 1100),
    "action.png": Picture("action", "light", 1440, 900),
    "graph.png": Picture("graph", "light", 1440, 900),
    "graph-dark.png": Picture("graph", "dark", 1440, 900),
    "fleet.png": Picture("fleet", "light", 1440, 620),
    "fleet-phone.png": Picture("fleet", "dark", 390, 844),
}


class Camera:
    """Takes each page in every scheme and width.

    Args:
        page: A tab of the browser.
        url: The dashboard's.
        folder: Where pictures of whole pages go.
        documents: The folder of the pictures in the documents, which are taken as well; None for none.
    """

    def __init__(self, page: Page, url: str, folder: Path, documents: Path | None = None) -> None:
        self.page = page
        self._url, self._folder, self._documents = url, folder, documents
        folder.mkdir(parents=True, exist_ok=True)

    def open(self, path: str) -> Page:
        """Go to a page of the dashboard, and wait until it is live and has all that it shows."""
        self.page.goto(f"{self._url}{path}")
        live = self.page.get_by_test_id("connection").filter(has_text=LIVE).or_(self.page.locator("main[data-live]"))
        expect(live).to_be_visible(timeout=PATIENCE_MS)
        self._settle()
        return self.page

    def take(self, name: str) -> None:
        """Take the page that is open."""
        for file, picture in DOCUMENTS.items():
            if self._documents is not None and picture.page == name:
                self._set(picture.scheme, picture.width, picture.height)
                size = self._shoot(self._documents / file, whole=False)
                assert size <= MAX_BYTES, f"{file} has {size} bytes"
        for width_name, (width, height) in SIZES.items():
            for scheme in SCHEMES:
                self._set(scheme, width, height)
                self._shoot(self._folder / f"{name}-{scheme}-{width_name}.png", whole=True)

    def _set(self, scheme: str, width: int, height: int) -> None:
        self.page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.mouse.move(0, 0)
        self.page.evaluate("window.scrollTo(0, 0)")
        expect(self.page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)
        self._settle()

    def _settle(self) -> None:
        expect(self.page.locator(BUSY)).to_have_count(0, timeout=PATIENCE_MS)
        self.page.wait_for_timeout(400)  # plots and pictures are drawn a moment after their data came

    def _shoot(self, path: Path, *, whole: bool) -> int:
        self.page.screenshot(path=path, animations="disabled", full_page=whole)
        size = path.stat().st_size
        sys.stdout.write(f"{path}: {size // 1000} kB\n")
        return size

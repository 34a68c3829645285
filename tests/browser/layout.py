"""What does not fit on a page, at every width that people use."""

import re
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urljoin

from playwright.sync_api import Page, expect

from tests.browser.axe import SETTLED

WIDTHS = (320, 390, 720, 1024, 1440)
"""CSS pixels: the narrowest that WCAG knows, a phone, a laptop at 200 % zoom, a tablet, a laptop."""
FAULTS = (Path(__file__).parent / "layout_faults.js").read_text(encoding="utf-8")
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def find_layout_faults(page: Page, widths: tuple[int, ...] = WIDTHS) -> list[str]:
    """What is cut off, lies on something, or leaves its box or the window; one line for each width and fault."""
    before = page.viewport_size
    found = []
    for width in widths:
        page.set_viewport_size({"width": width, "height": 1000})
        page.evaluate(DRAWN)
        page.evaluate(SETTLED)
        found += [f"{width}: {fault}" for fault in page.evaluate(FAULTS)]
    if before is not None:
        page.set_viewport_size(before)
    return found


def kind_of(path: str) -> str:
    """The path of a page without what names a thing: two goals have one page."""
    kind = re.sub(r"[0-9a-f]{8}-[0-9a-f-]{27,}", "*", path.partition("?")[0].partition("#")[0])
    return re.sub(r"^(/ui/(?:actions|help))/.*", r"\1/*", kind)


def walk_pages(page: Page, *starts: str) -> Iterator[str]:
    """Open some pages, and one of each further kind that links lead to; its path."""
    paths, seen = deque(starts), set[str]()
    while paths:
        path = paths.popleft()
        seen.add(kind_of(path))
        page.goto(urljoin(page.url, path))
        expect(page.get_by_role("heading", level=1).first).to_be_visible()
        expect(page.get_by_role("group", name="The page is loading")).to_have_count(0)
        yield path
        links = "[...document.querySelectorAll('a[href]')].map((link) => link.getAttribute('href'))"
        for link in page.evaluate(links):
            if re.match(r"/(ui/.*|\?.*)?$", link) and kind_of(link) not in seen | set(map(kind_of, paths)):
                paths.append(link)

"""What a page costs: processor time of the whole browser, memory of the page, frames and long tasks."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright
from tests.browser.conftest import ARGUMENTS, CHROMIUM, MISSING

from benchmarks.machine import Cpu

# How long tasks held up the page, since the last look. To count frames would make it draw more of them.
WATCH = """() => {
    window.watched = {long: 0, longest: 0};
    new PerformanceObserver((list) => {
        for (const {duration} of list.getEntries()) {
            window.watched.long += 1;
            window.watched.longest = Math.max(window.watched.longest, duration);
        }
    }).observe({type: "longtask"});
}"""
LOOK = "() => { const seen = window.watched; window.watched = {long: 0, longest: 0}; return seen; }"


@dataclass(frozen=True)
class Cost:
    """What a page cost in a while.

    Attributes:
        cpu: Processor time of the whole browser, in percent of one core.
        heap: Memory of the page's objects in MB.
        long_tasks: Times that the page was held up for 50 ms and more, for `longest_ms` at most.
    """

    cpu: float
    heap: float
    long_tasks: int
    longest_ms: float


class Watched:
    """A page that is open."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self._devtools: CDPSession = page.context.new_cdp_session(page)
        self._devtools.send("Performance.enable")
        page.evaluate(WATCH)

    def heap_mb(self) -> float:
        """Memory of the page's objects, garbage aside."""
        self._devtools.send("HeapProfiler.collectGarbage")
        metrics = self._devtools.send("Performance.getMetrics")["metrics"]
        return float(next(metric["value"] for metric in metrics if metric["name"] == "JSHeapUsedSize")) / 1e6

    def during(self, seconds: float) -> Cost:
        """Watch for so long."""
        heap = self.heap_mb()
        self.page.evaluate(LOOK)
        before = {pid: Cpu.of(pid) for pid in _processes_of(os.getpid()) if _is_browser(pid)}
        self.page.wait_for_timeout(seconds * 1000)
        cpu = 0.0
        for pid, then in before.items():
            with suppress(OSError):  # it has ended meanwhile
                cpu += Cpu.of(pid).percent_since(then)
        seen = self.page.evaluate(LOOK)
        return Cost(cpu, heap, seen["long"], seen["longest"])


@contextmanager
def opened_browser() -> Iterator[Browser]:
    """A browser with nothing in its cache."""
    if CHROMIUM is None:
        raise SystemExit(MISSING)
    with (
        sync_playwright() as playwright,
        playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS) as browser,
    ):
        yield browser


@contextmanager
def watched(url: str, *, width: int = 1440, height: int = 1200) -> Iterator[Watched]:
    """Open a page in a browser of its own."""
    with opened_browser() as browser:
        page = browser.new_page(viewport={"width": width, "height": height})
        page.goto(url)
        page.get_by_test_id("connection").get_by_text("live").wait_for()
        time.sleep(1.0)
        yield Watched(page)


def _processes_of(parent: int) -> list[int]:
    """What a process has started, and what that has."""
    children: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with suppress(OSError):
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
                children.setdefault(int(fields[1]), []).append(int(entry.name))
    found = [parent]
    for pid in found:
        found += children.get(pid, [])
    return found[1:]


def _is_browser(pid: int) -> bool:
    try:
        return (Path("/proc") / str(pid) / "comm").read_text().startswith("chrom")
    except OSError:
        return False

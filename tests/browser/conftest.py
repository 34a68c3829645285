"""A real browser on the real dashboard of a real gateway."""

import os
import shutil
from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, WebSocket, expect, sync_playwright
from playwright.sync_api import Error as PlaywrightError

from tests.support import shapes
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, ready_gateway
from tests.support.waiting import PATIENCE

PATIENCE_MS = 1000 * PATIENCE
expect.set_options(timeout=PATIENCE_MS)
RESULTS = Path(__file__).parents[2] / "test-results"
# The first has no window frame to draw, and so needs less processor time.
NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in NAMES if (path := shutil.which(name))), None)
MISSING = "no Chromium is installed (on Debian: sudo apt-get install chromium-headless-shell)"
ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "browser" in Path(item.fspath).parts:
            item.add_marker(pytest.mark.browser)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A failure shows what the page said, and what the gateway says; its picture is in `test-results`."""
    report = yield
    page, gateway = (getattr(item, "funcargs", {}).get(name) for name in ("page", "gateway"))
    if report.failed and isinstance(page, Page):
        with suppress(PlaywrightError):  # it is closed
            report.sections.append(("the page", page.locator("body").aria_snapshot(timeout=5_000)))
            page.screenshot(path=RESULTS / f"{item.name.replace('/', ' ')}.png", full_page=True)
    if report.failed and isinstance(gateway, RunningGateway):
        with suppress(httpx2.HTTPError, RuntimeError):  # it is gone, or its client is closed
            answers = [gateway.http.get(path).text for path in ("/readyz", "/stop", "/goals?limit=3")]
            report.sections.append(("the gateway", "\n".join(answers)))
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if CHROMIUM is None:
        terminalreporter.write_sep("!", f"THE BROWSER TESTS DID NOT RUN: {MISSING}", red=True, bold=True)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        if os.environ.get("CI") == "true":
            pytest.fail(MISSING)
        pytest.skip(MISSING)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    with ros_domain() as domain:
        yield domain


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ready_gateway(domain) as gateway:
        yield gateway


@pytest.fixture
def page(browser: Browser, gateway: RunningGateway, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The dashboard, open; a test fails where the page logged an error."""
    context = browser.new_context(reduced_motion="reduce", viewport={"width": 1440, "height": 1000})
    page = context.new_page()
    errors: list[str] = []

    def hear(message: ConsoleMessage) -> None:
        if message.type == "error":
            errors.append(f"{message.text} ({message.location.get('url')})")

    def check(socket: WebSocket) -> None:
        path = socket.url.removeprefix(gateway.url.replace("http", "ws"))
        socket.on("framereceived", lambda message: shapes.check_event(path, message))

    page.on("websocket", check)
    page.on("console", hear)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.set_default_timeout(PATIENCE_MS)
    page.goto(gateway.url)
    yield page
    context.close()
    gateway.stop_once()
    gateway.http.delete("/stop")
    gateway.http.delete("/battery/publisher")
    if not request.node.get_closest_marker("expect_page_errors"):
        assert errors == []

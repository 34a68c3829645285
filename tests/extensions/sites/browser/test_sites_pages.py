"""A hub of two sites: its pages are about both, and a robot is docked on the page of its site."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.axe import find_violations
from tests.browser.conftest import PATIENCE_MS
from tests.support import access
from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.hubs import RunningHub, running_hub, site_settings
from tests.support.nats import nats_server

# Through the hub, a stop of the site can be released, too.
RELEASES = {"hub_role": "supervisor"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("sites")


@pytest.fixture(scope="module")
def nats(folder: Path) -> Iterator[str]:
    with nats_server(folder) as server:
        yield server.url


@pytest.fixture(scope="module")
def berlin(domain: int, nats: str, folder: Path) -> Iterator[RunningGateway]:
    """A site with a docking server, and a robot whose battery is low."""
    settings = site_settings(nats, folder, "berlin") | RELEASES
    with running_dock_server(domain), running_gateway(domain, **settings) as gateway:
        gateway.wait_until_ready()
        gateway.publish(LOW)
        yield gateway


@pytest.fixture(scope="module")
def ada(folder: Path) -> str:
    """The secret of a token of the hub."""
    return access.Site(folder, f"sqlite:///{folder}/hub.db").token("ada", "admin")


@pytest.fixture(scope="module")
def hub(nats: str, folder: Path, berlin: RunningGateway, ada: str) -> Iterator[RunningHub]:
    settings = site_settings(nats, folder, "oslo") | RELEASES
    with (
        ros_domain() as domain,
        running_gateway(domain, **settings) as oslo,
        running_hub(nats, folder, authentication="true") as hub,
    ):
        oslo.publish(LOW)
        hub.http.headers["Authorization"] = f"Bearer {ada}"
        for site in ("berlin", "oslo"):
            hub.wait_for_site(site)
        yield hub


@pytest.fixture
def page(browser: Browser, hub: RunningHub, ada: str) -> Iterator[Page]:
    """The dashboard of the hub, open and logged in; a test fails where the page logged an error."""
    context = browser.new_context(reduced_motion="reduce", viewport={"width": 1440, "height": 1000})
    page = context.new_page()
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.set_default_timeout(PATIENCE_MS)
    page.goto(hub.url)
    log_in(page, ada)
    yield page
    context.close()
    assert errors == []


def log_in(page: Page, secret: str) -> None:
    page.get_by_role("button", name="Log in with a token").click()
    page.get_by_label("Token", exact=True).fill(secret)
    page.get_by_label("Token", exact=True).press("Enter")


def test_a_robot_is_docked_at_its_site_and_the_hub_shows_how_that_ended(page: Page, berlin: RunningGateway) -> None:
    expect(page.get_by_role("navigation", name="Sites").get_by_role("link")).to_have_count(2)
    expect(page.get_by_test_id("robot /oslo")).to_be_visible()
    assert find_violations(page) == []
    page.get_by_test_id("robot /berlin").get_by_role("link", name="/berlin").click()
    expect(page).to_have_url(re.compile(r"/sites/berlin/ui/robot\?robot=/$"))
    expect(page).to_have_title(re.compile("berlin · dock-gateway$"))
    expect(page.get_by_test_id("connection")).to_have_text("live")
    page.get_by_role("button", name="Dock", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Dock", exact=True).click()
    expect(page.get_by_role("button", name="Cancel", exact=True)).to_be_enabled()
    page.get_by_role("link", name="All sites").click()
    robot = page.get_by_test_id("robot /berlin")
    expect(robot).to_contain_text(re.compile("Dock.* s"))
    berlin.publish(CHARGING)
    expect(robot).to_contain_text("Reached the dock")
    page.get_by_role("link", name="Goals").click()
    page.get_by_role("table").get_by_role("link").first.click()
    expect(page).to_have_url(re.compile("/sites/berlin/ui/goals/"))
    page.go_back()
    expect(page.get_by_role("heading", name="Goals", level=1)).to_be_visible()
    expect(page).to_have_url(re.compile("[0-9]/ui/goals$"))


def test_a_stop_reaches_every_site(page: Page, hub: RunningHub) -> None:
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_role("alert").get_by_text("Stopped: berlin, oslo.")).to_be_visible()
    expect(page.get_by_test_id("stop-banner")).to_contain_text("All")
    page.get_by_role("link", name="Sites", exact=True).click()
    expect(page.get_by_test_id("site oslo")).to_contain_text("Stopped")
    assert find_violations(page) == []
    page.get_by_role("button", name="Release all …").click()
    page.get_by_role("dialog").get_by_role("button", name="Release all").click()
    expect(page.get_by_test_id("stop-banner")).to_have_count(0)
    expect(page.get_by_test_id("site oslo")).not_to_contain_text("Stopped")


def test_each_site_has_a_map(page: Page) -> None:
    page.get_by_role("link", name="Map", exact=True).click()
    for site in ("berlin", "oslo"):
        expect(page.get_by_role("region", name=f"Not on the map of {site}")).to_be_visible()
    assert find_violations(page) == []


def test_the_page_of_a_site_asks_for_the_login_of_the_hub_and_stops_that_site(
    page: Page, hub: RunningHub, ada: str
) -> None:
    """What one may do there is what the site gives the hub."""
    page.get_by_role("button", name="Logged in as ada, admin").wait_for()
    page.context.clear_cookies()
    page.goto(f"{hub.url}/sites/oslo/")
    log_in(page, ada)
    page.get_by_role("button", name="Logged in as ada, supervisor").wait_for()
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_role("alert").get_by_text("Stopped: oslo.")).to_be_visible()
    page.get_by_role("button", name="Release …").click()
    page.get_by_role("dialog").get_by_role("button", name="Release", exact=True).click()
    expect(page.get_by_test_id("stop-banner")).to_have_count(0)
    assert hub.get("/sites/berlin")["stop"]["robots"] == []

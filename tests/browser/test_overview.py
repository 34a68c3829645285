"""The overview of several robots: their rows, names, alerts and stops, the keyboard, and a gateway that is silent."""

import re
import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from dock_gateway.extension_list import OURS
from tests.browser.axe import find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway
from tests.support.installed import is_there
from tests.support.waiting import wait_until

ROBOTS = ("/robot1", "/robot2")
LOW = {"voltage": 20.1, "percentage": 0.12, "power_supply_status": 2}
CHARGING = {"voltage": 24.1, "percentage": 0.81, "power_supply_status": 1}
# Less than the page waits for a silent stream.
AT_ONCE_MS = 4_000


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """One gateway, two robots in namespaces of their own: one low, one on its dock."""
    with ExitStack() as stack:
        for robot in ROBOTS:
            stack.enter_context(running_dock_server(domain, "-r", f"__ns:={robot}"))
        gateway = stack.enter_context(running_gateway(domain))
        for robot, state in zip(ROBOTS, (LOW, CHARGING), strict=True):
            at = {"robot": robot}
            wait_until(lambda at=at: gateway.http.get("/docks", params=at).status_code == 200, robot)
            publish(gateway, robot, state)
        yield gateway


@pytest.fixture
def page(page: Page, gateway: RunningGateway) -> Iterator[Page]:
    """The overview, live, with a row for each robot."""
    for robot in ROBOTS:
        expect(row(page, robot)).to_be_visible()
    yield page
    gateway.http.delete("/stop")
    for robot in ROBOTS:
        gateway.http.delete("/stop", params={"robot": robot})
        gateway.stop_once(f"?robot={robot}")
    publish(gateway, ROBOTS[0], LOW)


def publish(gateway: RunningGateway, robot: str, state: dict[str, object]) -> None:
    body = {"state": state, "rate_hz": 5}
    gateway.http.put("/battery/publisher", params={"robot": robot}, json=body).raise_for_status()


def row(page: Page, robot: str) -> Locator:
    return page.get_by_test_id(f"robot {robot}")


def expect_order(page: Page, *robots: str) -> None:
    expect(page.get_by_role("rowheader").get_by_role("link")).to_have_text(robots)


def test_each_robot_at_a_glance(page: Page, gateway: RunningGateway) -> None:
    expect(row(page, "/robot1")).to_contain_text(re.compile("12 %.*low.*now.*Idle.*Connected"))
    expect(row(page, "/robot2")).to_contain_text(re.compile("Docked.*81 %.*charging.*now"))
    goal = gateway.http.post("/dock", params={"robot": "/robot1"}).json()["goal_id"]
    expect(row(page, "/robot1")).to_contain_text("Dock: ")
    gateway.http.post(f"/dock/{goal}/cancel")
    expect(row(page, "/robot1")).to_contain_text("Dock canceled")
    row(page, "/robot1").get_by_role("link", name="/robot1").click()
    expect(page.get_by_role("heading", level=1, name="/robot1")).to_be_visible()


def test_a_robot_is_named_and_found_by_its_group(page: Page, gateway: RunningGateway) -> None:
    """By keyboard alone, and each letter is kept however quickly it is typed."""
    row(page, "/robot2").get_by_role("link", name="/robot2").focus()
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Name and groups of /robot2").focus()
    page.keyboard.press("Enter")
    dialog = page.get_by_role("dialog", name="Name and groups of /robot2")
    expect(dialog.get_by_label("Name")).to_be_focused()
    page.keyboard.type("Left forklift")
    page.keyboard.press("Tab")
    expect(dialog.get_by_role("combobox", name="Groups")).to_be_focused()
    page.keyboard.type("Hall 1")
    page.keyboard.press("Enter")
    dialog.get_by_role("button", name="Save").press("Enter")
    expect(dialog).to_be_hidden()
    try:
        expect(page.get_by_role("heading", level=1, name="Left forklift")).to_be_visible()
        page.get_by_role("link", name=re.compile("^Overview")).first.press("Enter")
        expect(row(page, "/robot2").get_by_role("link", name="Left forklift")).to_be_visible()
        expect(row(page, "/robot2")).to_contain_text("/robot2")
        page.keyboard.press("/")
        page.keyboard.type("hall")
        expect(page.get_by_role("searchbox")).to_have_value("hall")
        expect(row(page, "/robot1")).to_be_hidden()
        expect_order(page, "Left forklift")
        expect(page).to_have_url(re.compile(r"[?&]q=hall$"))
        page.get_by_role("searchbox").fill("")
        expect_order(page, "/robot1", "Left forklift")
        page.get_by_label("Group", exact=True).select_option("Hall 1")
        expect_order(page, "Left forklift")
        alerts = page.get_by_role("region", name="Alerts")
        expect(alerts).to_contain_text("No active alerts in Hall 1.")
        expect(alerts).to_contain_text("1 alert of another robot is hidden by the group filter.")
        assert find_violations(page) == []
    finally:
        label: dict[str, object] = {"display_name": None, "groups": []}
        gateway.http.put("/label?robot=/robot2", json=label).raise_for_status()
    page.get_by_role("button", name="Show all 2").press("Enter")
    expect_order(page, "/robot1", "/robot2")


def test_an_alert_is_acknowledged_with_a_name_for_all_to_see(page: Page, browser: Browser) -> None:
    alerts = page.get_by_role("region", name="Alerts")
    expect(alerts).to_contain_text(re.compile("Low battery.*: /robot1", re.IGNORECASE))
    expect(page).to_have_title(re.compile(r"^\(1\) Overview"))
    page.get_by_role("link", name=re.compile("^Graph")).click()
    expect(page.get_by_test_id("alert-count")).to_have_text("1 alert")
    page.get_by_role("link", name=re.compile("^Overview")).click()
    alerts.get_by_role("button", name=re.compile("^Acknowledge")).click()
    dialog = page.get_by_role("dialog", name="Acknowledge as")
    dialog.get_by_label("Your name").fill("Ada")
    dialog.get_by_role("button", name="Acknowledge").click()
    expect(page.get_by_test_id("alert-count")).to_be_hidden()
    other = browser.new_page()
    other.goto(page.url)
    other.get_by_role("button", name="Show 1 more").click()
    expect(other.get_by_role("region", name="Alerts")).to_contain_text("Acknowledged by Ada")
    other.get_by_role("button", name=re.compile("^Withdraw")).click()
    expect(page.get_by_test_id("alert-count")).to_have_text("1 alert")
    other.close()


def test_each_stop_is_released_by_itself(page: Page, gateway: RunningGateway) -> None:
    for robot, by in zip(ROBOTS, ("Ada", "Grace"), strict=True):
        gateway.http.post("/stop", params={"robot": robot}, json={"by": by}).raise_for_status()
    banner = page.get_by_test_id("stop-banner")
    expect(banner).to_contain_text("All 2 robots are stopped")
    expect(row(page, "/robot2")).to_contain_text("Stopped by Grace")
    banner.get_by_role("button", name="Release /robot2 …").click()
    page.get_by_role("dialog").get_by_role("button", name="Release").click()
    expect(banner).to_contain_text("/robot1 stopped by Ada")

    def latched(robot: str) -> bool:
        return bool(gateway.http.get("/stop", params={"robot": robot}).json()["latched"])

    wait_until(lambda: not latched("/robot2"), "the release")
    assert latched("/robot1")


def test_stop_holds_all_robots_and_their_release_is_one(page: Page, gateway: RunningGateway) -> None:
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    banner = page.get_by_test_id("stop-banner")
    expect(banner).to_contain_text(re.compile("^All robots stopped by the dashboard at .*/robot1, /robot2: "))
    for robot in ROBOTS:
        assert gateway.http.get("/stop", params={"robot": robot}).json()["latched"] is True
    page.get_by_role("button", name="Release …").click()
    page.get_by_role("dialog").get_by_role("button", name="Release").click()
    expect(banner).to_be_hidden()
    for robot in ROBOTS:
        assert gateway.http.get("/stop", params={"robot": robot}).json()["latched"] is False


def test_the_keyboard_alone(page: Page) -> None:
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keyboard and name")).to_contain_text("Go to Graph")
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()
    for letter, name in (("g", "Goals"), ("a", "Actions"), ("r", "Graph"), ("o", "Overview")):
        page.keyboard.press("g")
        page.keyboard.press(letter)
        expect(page.get_by_role("heading", level=1, name=name)).to_be_attached()
    row(page, "/robot2").get_by_role("link", name="/robot2").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", level=1, name="/robot2")).to_be_visible()
    for other in ("/robot1", "2"):  # a name, or as little of it as tells it from the others
        page.get_by_role("combobox", name="Switch robot").focus()
        page.keyboard.type(other)
        page.keyboard.press("Enter")
        expect(page.get_by_role("heading", level=1, name=other)).to_be_visible()


@pytest.mark.expect_page_errors
def test_a_lost_network_is_said_at_once(page: Page) -> None:
    page.context.set_offline(True)
    expect(page.get_by_text("Reconnecting to the gateway")).to_be_visible(timeout=AT_ONCE_MS)
    expect(row(page, "/robot1")).to_contain_text("Not live")
    page.context.set_offline(False)
    expect(page.get_by_test_id("connection")).to_have_text("live")
    expect(row(page, "/robot1")).to_contain_text("Connected")


@pytest.mark.expect_page_errors
def test_a_frozen_gateway_is_said_within_seconds(page: Page, gateway: RunningGateway) -> None:
    gateway.process.send_signal(signal.SIGSTOP)
    try:
        begun = time.monotonic()
        expect(page.get_by_text("Reconnecting to the gateway")).to_be_visible()
        assert time.monotonic() - begun < 15
    finally:
        gateway.process.send_signal(signal.SIGCONT)
    expect(page.get_by_test_id("connection")).to_have_text("live")


def test_accessibility(page: Page, gateway: RunningGateway) -> None:
    expect(page.get_by_role("region", name="Alerts").get_by_role("listitem")).to_have_count(1)
    assert find_violations(page) == []
    gateway.http.post("/dock", params={"robot": "/robot2"})
    gateway.http.post("/stop", params={"robot": "/robot1"}, json={"by": "Ada"}).raise_for_status()
    expect(page.get_by_test_id("stop-banner")).to_be_visible()
    assert find_violations(page) == []
    page.get_by_role("button", name=re.compile("^Acknowledge: ")).first.click()
    expect(page.get_by_role("dialog", name="Acknowledge as")).to_be_visible()
    assert find_violations(page) == []


def test_the_pages_are_in_one_row_as_far_as_there_is_room_and_all_in_a_menu(page: Page) -> None:
    pages = page.get_by_role("navigation", name="Pages")
    links, menu = pages.get_by_role("link"), pages.get_by_role("button", name="Pages")
    count = 5 + sum(name in OURS for name in PAGES_OF_EXTENSIONS.values())
    for width, shown in ((820, 0), (1024, 3), (1280, min(6, count)), (1440, count), (1920, count)):
        page.set_viewport_size({"width": width, "height": 900})
        expect(links).to_have_count(shown)
        tops = links.evaluate_all("(links) => links.map((link) => link.getBoundingClientRect().top)")
        assert len(set(tops)) <= 1, width
        expect_no_sideways_scrolling(page)
        expect(menu).to_be_visible(visible=width < 1440)
    page.set_viewport_size({"width": 1024, "height": 900})
    menu.click()
    pages.get_by_role("link", name="Graph").click()
    expect(page.get_by_role("heading", level=1, name="Graph")).to_be_visible()


PAGES_OF_EXTENSIONS = {
    "Missions": "missions",
    "Statistics": "statistics",
    "Automatic docking": "automation",
    "Docks": "chargers",
}


@pytest.mark.parametrize("width", [320, 390, 600])
def test_where_it_is_narrow_the_pages_are_in_a_menu_and_none_scrolls_sideways(page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 800})
    pages = page.get_by_role("navigation", name="Pages")
    menu = pages.get_by_role("button", name="Pages")
    names = (
        "Map",
        "Goals",
        "Missions",
        "Actions",
        "Statistics",
        "Automatic docking",
        "Docks",
        "Graph",
        "Notifications",
        "Overview",
    )
    for name in (name for name in names if is_there(name, PAGES_OF_EXTENSIONS)):
        expect(pages.get_by_role("link")).to_have_count(0)
        menu.press("Enter")
        pages.get_by_role("link", name=name).press("Enter")
        expect(page.get_by_role("heading", level=1, name=name)).to_be_attached()
        expect(page.locator("main .mantine-Skeleton-root:visible")).to_have_count(0)
        expect_no_sideways_scrolling(page, name)
    page.set_viewport_size({"width": width, "height": 320})
    menu.click()
    pages.get_by_role("link", name="Notifications").scroll_into_view_if_needed()
    expect(pages.get_by_role("link", name="Notifications")).to_be_in_viewport(ratio=1)
    page.keyboard.press("Escape")
    expect(menu).to_have_attribute("aria-expanded", "false")
    row(page, ROBOTS[0]).get_by_role("link", name=ROBOTS[0]).click()
    for tab in ("Developer", "Operate"):
        page.get_by_role("tab", name=tab).click()
        expect(page.locator("main .mantine-Skeleton-root:visible")).to_have_count(0)
        expect_no_sideways_scrolling(page, tab)


@pytest.mark.parametrize("width", [320, 390, 600, 820, 1024, 1920])
def test_a_width(page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    expect(row(page, "/robot2")).to_contain_text("81 %")
    expect(page.get_by_test_id("alert-count")).to_be_visible()
    expect_no_sideways_scrolling(page)
    assert find_wide_cells(page) == []


def find_wide_cells(page: Page) -> list[str]:
    """Cells of the table whose words are cut off."""
    cut: list[str] = page.evaluate(
        "[...document.querySelectorAll('td, th')].filter((cell) => cell.scrollWidth > cell.clientWidth + 1)"
        ".map((cell) => cell.textContent)"
    )
    return cut

"""Many robots: their list, commands for several of them, the search that Ctrl+K opens, and the wall."""

import re
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.axe import find_violations
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

COUNT = 80
# Those that have a docking server.
DOCKING = ("/robot1", "/robot2")
GROUP = (*DOCKING, "/robot3")


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """One gateway and many robots: two can dock, and a third is in their group."""
    crowd = ("-m", "tests.support.robots", "--robots", str(COUNT))
    with ExitStack() as stack:
        for robot in DOCKING:
            stack.enter_context(running_dock_server(domain, "-r", f"__ns:={robot}"))
        stack.enter_context(ForkedProcess(*crowd, env=ros_environment(domain)))
        gateway = stack.enter_context(running_gateway(domain))
        wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) >= COUNT, "all robots", 60)
        for robot in DOCKING:
            wait_until(lambda at={"robot": robot}: gateway.http.get("/docks", params=at).status_code == 200, robot)
        for robot in GROUP:
            label: dict[str, object] = {"display_name": None, "groups": ["Hall 1"]}
            gateway.http.put(f"/label?robot={robot}", json=label).raise_for_status()
        yield gateway


@pytest.fixture
def page(page: Page, gateway: RunningGateway) -> Iterator[Page]:
    yield page
    for robot in GROUP:
        gateway.http.delete("/stop", params={"robot": robot})


def row(page: Page, robot: str) -> Locator:
    return page.get_by_test_id(f"robot {robot}")


def test_a_long_list_has_the_rows_in_sight(page: Page) -> None:
    """Scrolled to its end and by keyboard, the row in sight is the right one, and the head stays in sight."""
    table = page.get_by_role("table", name="Robots")
    expect(table).to_have_attribute("aria-rowcount", str(COUNT + 1))
    expect(row(page, "/robot1")).to_have_attribute("aria-rowindex", "2")
    assert page.get_by_role("rowheader").count() < COUNT
    expect(row(page, f"/robot{COUNT}")).to_have_count(0)
    page.get_by_label("Select /robot1", exact=True).focus()
    page.evaluate("window.scrollTo(0, document.body.scrollHeight)")
    last = row(page, f"/robot{COUNT}")
    expect(last).to_be_in_viewport()
    expect(last).to_have_attribute("aria-rowindex", str(COUNT + 1))
    expect(page.get_by_role("columnheader", name="Robot")).to_be_in_viewport()
    # The row that has the focus is kept.
    expect(page.get_by_label("Select /robot1", exact=True)).to_be_focused()


def test_the_robots_of_a_group_are_docked_canceled_and_stopped(page: Page, gateway: RunningGateway) -> None:
    page.get_by_label("Group", exact=True).select_option("Hall 1")
    expect(page.get_by_role("rowheader")).to_have_count(len(GROUP))
    top = row(page, "/robot1").bounding_box()
    page.get_by_label("Select all 3 that are listed").check()
    expect(page.get_by_text("3 selected")).to_be_visible()
    assert row(page, "/robot1").bounding_box() == top, "the table does not move"

    selected = page.get_by_role("group", name="Commands for the selected robots")
    selected.get_by_role("button", name="Dock", exact=True).click()
    dialog = page.get_by_role("dialog", name="Dock 2 robots?")
    expect(dialog).to_contain_text("/robot1, /robot2")
    expect(dialog.get_by_label("Left out")).to_contain_text(re.compile("No server offers the action.*/robot3"))
    dialog.get_by_role("button", name="Dock 2 robots").click()
    expect(page.get_by_text("Dock: all 2 robots accepted")).to_be_visible()
    for robot in DOCKING:
        expect(row(page, robot)).to_contain_text("Dock: ")

    # One of them by its row's menu, by keyboard.
    row(page, "/robot1").get_by_role("button", name="Commands for /robot1").press("Enter")
    item = page.get_by_role("menuitem", name="Cancel")
    expect(page.get_by_role("menuitem", name="Dock", exact=True)).to_be_disabled()
    expect(item).to_be_enabled()
    item.press("Enter")
    expect(row(page, "/robot1")).to_contain_text("Dock canceled")

    # A Stop of those that are selected, by a range: at once, and of no other robot.
    page.get_by_role("button", name="Clear the selection").click()
    page.get_by_label("Select /robot1", exact=True).click()
    page.get_by_label("Select /robot2", exact=True).click(modifiers=["Shift"])
    expect(page.get_by_text("2 selected")).to_be_visible()
    selected.get_by_role("button", name="Stop").click()
    expect(page.get_by_test_id("stop-banner")).to_contain_text("2 robots stopped")
    stops = {robot: gateway.http.get("/stop", params={"robot": robot}).json()["latched"] for robot in GROUP}
    assert stops == {"/robot1": True, "/robot2": True, "/robot3": False}


def test_the_search_leads_everywhere_by_keyboard_alone(page: Page, gateway: RunningGateway) -> None:
    search = page.get_by_role("dialog", name="Search and commands")
    found = search.get_by_role("listbox", name="Found")

    def choose(text: str, first: str) -> None:
        page.keyboard.press("Control+k")
        expect(search.get_by_role("combobox")).to_be_focused()
        page.keyboard.type(text)
        expect(found.get_by_role("option", selected=True)).to_have_text(re.compile(f"^{first}"))
        page.keyboard.press("Enter")
        expect(search).to_be_hidden()

    expect(row(page, "/robot1")).to_be_visible()
    choose("robot2", "/robot2")
    expect(page.get_by_role("heading", level=1, name="/robot2")).to_be_visible()
    choose("stati", "Statistics")
    expect(page.get_by_role("heading", level=1, name="Statistics")).to_be_visible()
    choose("robot2/connect", "/robot2/connect_to_charging_dock")
    expect(page.get_by_role("heading", level=1)).to_contain_text("/robot2/connect_to_charging_dock")

    choose("dock robot2", "Dock /robot2")
    dialog = page.get_by_role("dialog", name="Dock /robot2?")
    expect(dialog.get_by_role("button", name="Leave it where it is")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Dock: /robot2 accepted")).to_be_visible()
    goals = gateway.http.get("/goals", params={"robot": "/robot2", "limit": 1}).json()["goals"]
    choose(goals[0]["goal_id"][:8], "Goal ")
    expect(page).to_have_url(re.compile(goals[0]["goal_id"]))
    gateway.wait_for_goal(goals[0]["goal_id"], "executing")
    expect(page.get_by_text("executing").first).to_be_visible()
    choose("cancel robot2", "Cancel /robot2")
    expect(page.get_by_text("Cancel: /robot2 accepted")).to_be_visible()
    gateway.wait_for_goal(goals[0]["goal_id"], "canceled")

    # One Escape closes it and stops nothing; two stop, also while it is open.
    page.keyboard.press("Control+k")
    expect(search.get_by_role("combobox")).to_be_focused()
    page.keyboard.press("Escape")
    expect(search).to_be_hidden()
    page.keyboard.press("Tab")
    assert gateway.http.get("/stop").json()["latched"] is False
    page.keyboard.press("Control+k")
    expect(search.get_by_role("combobox")).to_be_focused()
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    expect(page.get_by_test_id("stop-banner")).to_be_visible()


@pytest.mark.expect_page_errors
def test_the_wall_needs_no_hand(page: Page, gateway: RunningGateway) -> None:
    """It fits the screen, says what is wrong, comes back after an outage and with a new build; Escape leaves it."""
    page.get_by_role("link", name="Wall").press("Enter")
    expect(page.get_by_role("heading", level=1)).to_have_text(re.compile(f"^All robots{COUNT}, page 1 of"))
    expect(page.get_by_test_id("tile /robot1")).to_contain_text("50 %")
    assert page.evaluate("document.documentElement.scrollHeight") == page.evaluate("innerHeight")

    page.goto(f"{gateway.url}/ui/wall?group=Hall+1")
    expect(page.get_by_role("heading", level=2)).to_have_text(GROUP)
    gateway.http.post("/stop", params={"robot": "/robot1"}, json={"by": "Ada"}).raise_for_status()
    expect(page.get_by_role("status")).to_have_text("/robot1 stopped by Ada")
    expect(page.get_by_test_id("tile /robot1")).to_contain_text("Stopped by Ada")
    assert find_violations(page, buttons=False) == []

    page.evaluate("document.body.dataset.before = 'yes'")
    page.context.set_offline(True)
    expect(page.get_by_role("status")).to_contain_text("Reconnecting to the gateway")
    other = '<script type="module" crossorigin src="/assets/another.js"></script>'
    page.route(f"{gateway.url}/", lambda route: route.fulfill(body=other, content_type="text/html"))
    page.context.set_offline(False)
    expect(page.locator("body:not([data-before])")).to_be_attached()
    expect(page.get_by_role("status")).to_have_text("/robot1 stopped by Ada")
    page.unroute(f"{gateway.url}/")

    leave = page.get_by_role("link", name="Leave (Esc)")
    expect(leave).to_have_css("opacity", "0")
    page.mouse.move(200, 300)
    page.mouse.move(220, 300)
    expect(leave).to_have_css("opacity", "1")
    page.keyboard.press("Escape")
    expect(page.get_by_role("rowheader")).to_have_count(len(GROUP))


def test_accessibility(page: Page) -> None:
    expect(row(page, "/robot1")).to_be_visible()
    page.get_by_label("Select /robot1", exact=True).check()
    page.get_by_label("Select /robot3", exact=True).check()
    assert find_violations(page) == []
    row(page, "/robot3").get_by_role("button", name="Commands for /robot3").click()
    expect(page.get_by_role("menuitem", name="Dock", exact=True)).to_be_focused()
    assert find_violations(page) == []
    page.keyboard.press("Escape")
    selected = page.get_by_role("group", name="Commands for the selected robots")
    selected.get_by_role("button", name="Dock", exact=True).click()
    expect(page.get_by_role("dialog", name="Dock 1 robot?")).to_be_visible()
    assert find_violations(page) == []
    page.keyboard.press("Escape")
    page.keyboard.press("Control+k")
    page.get_by_role("combobox", name="Search and commands").fill("robot80")
    expect(page.get_by_role("option", name=re.compile("^Dock .robot80"))).to_be_visible()
    assert find_violations(page) == []

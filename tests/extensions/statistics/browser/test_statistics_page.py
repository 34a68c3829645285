"""The statistics by clicking: every number leads to its goals; in both colour schemes and on narrow screens."""

import re
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa
from playwright.sync_api import Locator, Page, expect

from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.storage.rows import goal_row
from dock_gateway.storage.schema import create_tables
from dock_gateway.storage.tables import goals, prepare_for
from tests.browser.axe import find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import RunningGateway, running_gateway

TYPE = "action_tutorials_interfaces/action/ConnectToChargingDock"
BLOCKED = GoalError("blocked", "something is in the way")
ENDS = [*[(GoalStatus.SUCCEEDED, None)] * 7, (GoalStatus.CANCELED, None), (GoalStatus.ABORTED, BLOCKED)]

# Selects the first option of each labelled field, without a pause.
CLEAR = """labels => labels.forEach(label => {
    const field = [...document.querySelectorAll("label")].find(each => each.textContent === label).control
    field.selectedIndex = 0
    field.dispatchEvent(new Event("change", {bubbles: true}))
})"""


@pytest.fixture(scope="module")
def gateway(domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningGateway]:
    """A gateway whose history has 18 goals of two robots in two days."""
    path = tmp_path_factory.mktemp("history") / "history.db"
    fill(path)
    with running_gateway(domain, database_url=f"sqlite:///{path}") as gateway:
        gateway.wait_until_stored()
        yield gateway


def fill(path: Path) -> None:
    prepare_for("sqlite")
    engine = sa.create_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        create_tables(connection)
        connection.execute(sa.insert(goals), [goal_row(make_goal(number)) for number in range(2 * len(ENDS))])
    engine.dispose()


def make_goal(number: int) -> Goal:
    created = datetime.now(UTC) - timedelta(hours=2 * number + 1)
    action = f"/robot{number % 2 + 1}/connect_to_charging_dock"
    goal = Goal(f"00000000-0000-4000-8000-{number:012}", action, TYPE, created)
    goal.status, goal.error = ENDS[number // 2]
    goal.finished_at = goal.updated_at = created + timedelta(seconds=30 + number)
    return goal


def row_of(page: Page, region: str, name: str) -> Locator:
    return page.get_by_role("region", name=region).get_by_role("row").filter(has_text=name)


def test_numbers_lead_to_their_goals(page: Page, gateway: RunningGateway) -> None:
    page.get_by_role("link", name="Statistics").click()
    expect(page.get_by_role("region", name="By day").get_by_role("row")).to_have_count(8)
    page.get_by_role("radiogroup", name="Group by").get_by_text("Robot", exact=True).click()
    row = row_of(page, "By robot", "/robot2")
    expect(row).to_contain_text("87.5 %")
    row.get_by_role("link", name="1: aborted goals").click()
    listed = page.get_by_role("table").locator("tbody tr")
    expect(listed).to_have_count(1)
    expect(listed).to_contain_text(re.compile("/robot2/.*aborted.*Robot was blocked"))
    page.go_back()
    expect(page).to_have_url(re.compile("by=robot"))
    row_of(page, "Errors", "blocked").get_by_role("link", name="Robot was blocked").click()
    expect(listed).to_have_count(2)
    expect(page.get_by_label("Error", exact=True)).to_have_value("chosen")


def test_points_of_plots_lead_to_their_goals(page: Page, gateway: RunningGateway) -> None:
    """By keyboard: the newest day is where it enters, the arrows go on, Enter opens the goals."""
    page.goto(f"{gateway.url}/ui/statistics?by=action")
    plots = page.get_by_test_id("day-plot")
    expect(plots).to_have_count(3)
    rate = plots.filter(has_text="Success rate").get_by_role("link")
    rate.last.focus()
    page.keyboard.press("Home")
    expect(rate.first).to_be_focused()
    count = (rate.first.get_attribute("aria-label") or "").split(" of ")[1].split()[0]
    page.keyboard.press("Enter")
    expect(page.get_by_role("table").locator("tbody tr")).to_have_count(int(count))
    page.go_back()
    plots.filter(has_text="Errors").get_by_role("link", name="Robot was blocked", exact=True).click()
    expect(page.get_by_role("table").locator("tbody tr")).to_have_count(2)


def test_one_robot_at_any_dates(page: Page, gateway: RunningGateway) -> None:
    page.goto(f"{gateway.url}/ui/statistics?robot=/robot1&last=30d")
    total = page.get_by_role("region", name="All goals")
    expect(total.get_by_role("link", name="9: goals that ended")).to_be_visible()
    page.get_by_text("Dates", exact=True).click()
    page.get_by_text("UTC", exact=True).click()
    page.get_by_label("From, day").fill("2020-01-01")
    page.get_by_label("Until, day").fill("2020-01-02")
    expect(page.get_by_text("No goal ended")).to_be_visible()
    expect(page.get_by_text("days in UTC")).to_be_visible()
    page.get_by_label("From, day").fill("2019-12-01")
    page.get_by_label("From, time of day").fill("13:30")
    expect(page).to_have_url(re.compile(r"since=2019-12-01T13%3A30%3A00.000Z&until=2020-01-03T00%3A00"))


def test_a_group_and_a_tag(page: Page, gateway: RunningGateway) -> None:
    """They stay in the address, and go with the links to the goals."""
    label = {"display_name": None, "groups": ["Hall 1"]}
    assert gateway.http.put("/label?robot=/robot1", json=label).status_code == 200
    gateway.http.put("/label?robot=/robot2", json=label | {"groups": ["Hall 2"]})
    for number in (0, 1, 2):
        gateway.http.put(f"/goals/00000000-0000-4000-8000-{number:012}/tags", json={"tags": ["night shift"]})
    page.goto(f"{gateway.url}/ui/statistics?by=robot&last=30d&group=Hall+1")
    total = page.get_by_role("region", name="All goals")
    expect(total.get_by_role("link", name="9: goals that ended")).to_be_visible()
    page.get_by_role("combobox", name="Tag").select_option("night shift")
    expect(page).to_have_url(re.compile(r"group=Hall\+1&tag=night\+shift"))
    expect(page.get_by_role("combobox", name="Group")).to_have_value("Hall 1")
    assert find_violations(page) == []
    row_of(page, "By robot", "/robot1").get_by_role("link", name="2: goals that ended").click()
    listed = page.get_by_role("table").locator("tbody tr")
    expect(listed).to_have_count(2)
    page.get_by_role("combobox", name="Action").select_option("All actions")
    page.get_by_role("combobox", name="Tag").select_option("With and without")
    expect(listed).to_have_count(9)
    page.get_by_role("combobox", name="Group").select_option("All groups")
    expect(listed).to_have_count(18)


def test_filters_that_change_at_once(page: Page, gateway: RunningGateway) -> None:
    """None is lost, however soon the next one follows: a slow tablet renders later than a finger moves."""
    page.goto(f"{gateway.url}/ui/goals?action=/robot1/connect_to_charging_dock&robot=/robot1")
    listed = page.get_by_role("table").locator("tbody tr")
    expect(listed).to_have_count(9)
    page.evaluate(CLEAR, ["Action", "Robot"])
    expect(listed).to_have_count(18)


def test_accessibility(page: Page, gateway: RunningGateway) -> None:
    page.goto(f"{gateway.url}/ui/statistics?by=robot")
    expect(row_of(page, "By robot", "/robot2")).to_be_visible()
    assert find_violations(page) == []


@pytest.mark.parametrize("width", [320, 768])
@pytest.mark.parametrize(
    ("by", "more"), [("day", ""), ("action", "&since=2026-01-01T00:00:00Z&until=2099-01-01T00:00:00Z")]
)
def test_a_narrow_window(page: Page, gateway: RunningGateway, width: int, by: str, more: str) -> None:
    """Nothing is cut off or scrolled sideways (WCAG 1.4.10)."""
    page.set_viewport_size({"width": width, "height": 1000})
    page.goto(f"{gateway.url}/ui/statistics?by={by}{more}")
    region = page.get_by_role("region", name=f"By {by}")
    expect(region.get_by_role("link").first).to_be_visible()
    assert region.evaluate("card => card.scrollWidth <= card.clientWidth")
    expect_no_sideways_scrolling(page)

"""The list of goals and the page of a goal by clicking: two browsers on one goal, files, sending again, no stream."""

import csv
import io
import json
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Download, Page, expect

from tests.browser.axe import find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_dock_server, running_gateway, running_program
from tests.support.processes import client_process
from tests.support.waiting import wait_until

DOCK = "/connect_to_charging_dock"
# Texts that are drawn on a canvas, each with how far it sticks out of it.
RECORD_LABELS = """window.labels = [];
const draw = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, x, y, ...rest) {
    const {width} = this.measureText(text);
    const at = this.getTransform().transformPoint({x, y});
    const left = at.x - (this.textAlign === "right" ? width : this.textAlign === "center" ? width / 2 : 0);
    window.labels.push([text, Math.max(-left, left + width - this.canvas.width)]);
    return draw.call(this, text, x, y, ...rest);
};"""


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        stack.enter_context(running_dock_server(domain))
        stack.enter_context(running_program(domain, "fibonacci_action_server"))
        gateway = stack.enter_context(running_gateway(domain))
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the Fibonacci action")
        yield gateway


def press(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def expect_status(page: Page, status: str) -> None:
    expect(page.get_by_test_id("goal-status")).to_have_text(status)


def count_of(order: int, gateway: RunningGateway) -> str:
    """Send a Fibonacci goal and wait for its end."""
    answer = gateway.http.post("/actions/fibonacci/goals", json={"order": order}, headers={"Prefer": "wait=50"})
    goal: dict[str, Any] = answer.raise_for_status().json()
    assert goal["status"] == "succeeded"
    return str(goal["goal_id"])


def docking(gateway: RunningGateway, rate_hz: float = 10.0) -> str:
    """Send a docking goal that runs until the battery charges."""
    gateway.publish(LOW, rate_hz)
    return str(gateway.http.post("/dock").raise_for_status().json()["goal_id"])


def open_goal(page: Page, gateway: RunningGateway, goal_id: str) -> None:
    page.goto(f"{gateway.url}/ui/goals/{goal_id}")
    expect(page.get_by_test_id("goal-status")).to_be_visible()


def feedback_count(page: Page) -> int:
    match = re.search(r"(\d+) messages?", page.get_by_test_id("feedback-count").inner_text())
    assert match
    return int(match.group(1))


def saved(page: Page, link: str, download: Callable[[], None]) -> str:
    """What a click on a link downloads."""
    with page.expect_download() as waiting:
        download()
    file: Download = waiting.value
    path: Path = file.path()
    assert file.failure() is None, link
    return path.read_text(encoding="utf-8")


def export(page: Page, name: str) -> str:
    link = page.get_by_role("link", name=re.compile(f"^Export {name}"))
    return saved(page, name, link.click)


def test_two_browsers_watch_one_goal(page: Page, browser: Browser, gateway: RunningGateway) -> None:
    goal_id = docking(gateway)
    open_goal(page, gateway, goal_id)
    other = browser.new_page(reduced_motion="reduce", viewport={"width": 820, "height": 1000})
    # The second one comes later, by the link that the first one shares: it has what it missed.
    wait_until(lambda: feedback_count(page) >= 10, "some feedback in the first browser")
    other.goto(page.url)
    for each in (page, other):
        expect_status(each, "executing")
    wait_until(lambda: feedback_count(other) >= 10, "the same feedback in the second browser")
    press(other, "Cancel")
    for each in (page, other):
        expect_status(each, "canceled")
    told = gateway.goal(goal_id)["feedback_count"]
    for each in (page, other):
        expect(each.get_by_test_id("feedback-count")).to_have_text(f"{told} messages")
        expect(each.get_by_test_id("timeline").get_by_role("listitem").last).to_contain_text("canceled")
    other.close()


@pytest.mark.expect_page_errors
def test_the_feedback_has_no_gap_and_no_double(page: Page, gateway: RunningGateway) -> None:
    goal_id = docking(gateway, rate_hz=50.0)
    wait_until(lambda: gateway.goal(goal_id)["feedback_count"] > 50, "feedback before the page is open")
    open_goal(page, gateway, goal_id)
    wait_until(lambda: feedback_count(page) > 100, "feedback while the page is open")
    page.context.set_offline(True)
    expect(page.get_by_test_id("connection")).not_to_have_text("live")
    seen = gateway.goal(goal_id)["feedback_count"]
    wait_until(lambda: gateway.goal(goal_id)["feedback_count"] > seen + 25, "feedback while the page is cut off")
    page.context.set_offline(False)
    expect(page.get_by_test_id("connection")).to_have_text("live")
    gateway.publish(CHARGING)
    gateway.wait_for_goal(goal_id, "succeeded")
    expect_status(page, "succeeded")
    events = gateway.http.get(f"/goals/{goal_id}/history?type=feedback&limit=5000").json()["events"]
    expect(page.get_by_test_id("feedback-count")).to_have_text(f"{len(events)} messages")
    assert len({event["id"] for event in events}) == len(events) == gateway.goal(goal_id)["feedback_count"]


def test_a_goal_is_read_and_its_files_are_had(page: Page, gateway: RunningGateway) -> None:
    goal_id = count_of(6, gateway)
    open_goal(page, gateway, goal_id)
    left, right = (page.get_by_role("region", name=name).bounding_box() for name in ("Timeline", "Feedback"))
    assert left
    assert right
    assert left["x"] + left["width"] < right["x"]
    expect(page.get_by_role("list", name="Goal").get_by_text("order")).to_be_visible()
    expect(page.get_by_role("list", name="Result").get_by_text("0, 1, 1, 2, 3, 5, 8")).to_be_visible()
    last = page.get_by_role("img", name="partial_sequence (last) over time, between 1 and 8")
    expect(last).to_be_visible()
    expect(page.get_by_test_id("plot-value")).to_have_text("8")
    page.get_by_label("Add a plot").select_option("partial_sequence (length)")
    expect(page).to_have_url(re.compile(r"plot=partial_sequence\+%28last%29&plot=partial_sequence\+%28length%29"))
    page.reload()
    expect(last).to_be_visible()
    expect(page.get_by_test_id("plot-value")).to_have_text(["8", "7"])
    page.get_by_role("button", name="Remove the plot of partial_sequence (last)").click()
    expect(page.get_by_test_id("plot-value")).to_have_text(["7"])
    whole = json.loads(export(page, "JSON"))
    assert whole["goal_id"] == goal_id
    rows = list(csv.DictReader(io.StringIO(export(page, "CSV"))))
    assert [row["partial_sequence.2"] for row in rows][-1] == "1"
    assert len(rows) == whole["feedback_count"]


def test_one_crosshair_for_plots_and_table(page: Page, gateway: RunningGateway) -> None:
    goal_id = count_of(6, gateway)
    page.goto(f"{gateway.url}/ui/goals/{goal_id}?plot=partial_sequence+(last)&plot=partial_sequence+(length)")
    values, table = page.get_by_test_id("plot-value"), page.get_by_test_id("feedback-table")
    expect(values).to_have_text(["8", "7"])
    rows = table.locator("tbody tr")
    rows.last.hover()
    expect(values).to_have_text(["1", "3"])
    expect(rows.last).to_have_attribute("data-marked", "true")
    plot = page.get_by_role("img", name=re.compile("length"))
    for cursor in page.locator(".u-cursor-x").all():
        expect(cursor).to_have_css("transform", re.compile(r"matrix\(1, 0, 0, 1, [1-9]"))
    box = plot.bounding_box()
    assert box
    # Far at the right: the last message, which is the first row.
    page.mouse.move(box["x"] + box["width"] - 40, box["y"] + 60)
    expect(rows.first).to_have_attribute("data-marked", "true")
    expect(values).to_have_text(["8", "7"])
    page.mouse.click(box["x"] + box["width"] / 10, box["y"] + 60)
    expect(page.get_by_role("heading", name=re.compile("^Message at"))).to_be_visible()
    expect(rows.last.get_by_role("button")).to_have_attribute("aria-pressed", "true")


def test_a_goal_is_replayed_by_keyboard(page: Page, gateway: RunningGateway) -> None:
    goal_id = count_of(6, gateway)
    open_goal(page, gateway, goal_id)
    scrubber = page.get_by_role("slider", name="Moment of the goal")
    scrubber.focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_test_id("replay-moment")).to_have_text("0.1 s")
    expect(page).to_have_url(re.compile(r"at=0\.1$"))
    for _ in range(2):
        page.keyboard.press("PageUp")
    expect(page).not_to_have_url(re.compile(r"at=0\.1$"))
    expect(page.get_by_role("heading", name=re.compile("^Message at"))).to_be_visible()
    address, moment = page.url, page.get_by_test_id("replay-moment").inner_text()
    page.goto(gateway.url)
    page.goto(address)
    expect(page.get_by_test_id("replay-moment")).to_have_text(moment)
    press(page, "Play")
    expect(page.get_by_test_id("replay-moment")).not_to_have_text(moment)
    press(page, "Pause")
    expect(page).not_to_have_url(address)
    press(page, "End replay")
    expect(page).not_to_have_url(re.compile("at="))


@pytest.mark.parametrize("width", [320, 1440])
def test_the_labels_of_a_plot_are_whole(page: Page, gateway: RunningGateway, width: int) -> None:
    """Numbers with ten digits are not clipped at the left, nor times at the right."""
    goal_id = count_of(3, gateway)
    history = gateway.http.get(f"/goals/{goal_id}/history").json()
    for event in history["events"]:
        if event["type"] == "feedback":
            event["feedback"] = {"large": 1e9 * len(event["feedback"]["partial_sequence"])}
    page.route(f"**/goals/{goal_id}/history*", lambda route: route.fulfill(json=history))
    page.set_viewport_size({"width": width, "height": 1000})
    page.add_init_script(RECORD_LABELS)
    open_goal(page, gateway, goal_id)
    for label in ("00000000$", " s$"):
        page.wait_for_function("label => labels.some(([text]) => new RegExp(label).test(text))", arg=label)
    assert [label for label in page.evaluate("labels") if label[1] > 0] == []


def test_the_list_is_live_and_its_filters_are_in_the_address(page: Page, gateway: RunningGateway) -> None:
    count_of(2, gateway)
    page.goto(f"{gateway.url}/ui/goals")
    rows = page.get_by_role("table").locator("tbody tr")
    expect(rows.first).to_contain_text("/fibonacci")
    goal_id = docking(gateway)
    expect(rows.first).to_contain_text(re.compile(f"{DOCK}.*executing"))
    page.get_by_text("Running", exact=True).click()
    expect(page).to_have_url(re.compile(r"\?status=running$"))
    expect(rows).to_have_count(1)
    page.get_by_label("Action").select_option(DOCK)
    page.reload()
    expect(rows).to_have_count(1)
    expect(page.get_by_label("Action")).to_have_value(DOCK)
    gateway.http.post(f"/goals/{goal_id}/cancel").raise_for_status()
    expect(page.get_by_text("No goal fits")).to_be_visible()
    press(page, "Show all goals")
    expect(rows.first).to_contain_text("canceled")
    page.get_by_text("Canceled", exact=True).click()
    expect(rows.first).to_contain_text("canceled")
    exported = json.loads(export(page, "JSON"))
    assert exported
    assert {goal["status"] for goal in exported} == {"canceled"}
    page.get_by_label("Goal id").fill(goal_id[:8])
    expect(page).to_have_url(re.compile(f"id={goal_id[:8]}"))
    expect(rows).to_have_count(1)
    rows.first.get_by_role("link").click()
    expect_status(page, "canceled")
    expect(page).to_have_url(re.compile(goal_id))


def test_views_are_kept_and_times_are_utc(page: Page, gateway: RunningGateway) -> None:
    goal_id = count_of(2, gateway)
    page.goto(f"{gateway.url}/ui/goals?id={goal_id[:8]}")
    rows = page.get_by_role("table").locator("tbody tr")
    page.get_by_text("24 h", exact=True).click()
    page.get_by_text("UTC", exact=True).click()
    created = gateway.http.get(f"/goals/{goal_id}").json()["created_at"]
    expect(rows.get_by_role("link").first).to_have_text(re.compile(rf"{created[11:19]}$"))
    press(page, "Views")
    page.get_by_label("Name of the view").fill("The last one")
    assert find_violations(page) == []
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    page.get_by_text("Dates", exact=True).click()
    page.get_by_label("Until, day").fill("2020-01-02")
    expect(page.get_by_text("No goal fits")).to_be_visible()
    page.reload()
    press(page, "Views")
    page.get_by_role("link", name="The last one").click()
    expect(page).to_have_url(re.compile(rf"last=24h&id={goal_id[:8]}$"))
    expect(rows).to_have_count(1)
    open_goal(page, gateway, goal_id)
    shown = re.compile(rf"^(\w+ \d+, )?{created[11:19]}$")  # with its day once midnight has passed
    expect(page.get_by_test_id("timeline").locator("time").first).to_have_text(shown)


def test_notes_and_tags(page: Page, browser: Browser, gateway: RunningGateway) -> None:
    goal_id = count_of(2, gateway)
    open_goal(page, gateway, goal_id)
    other = browser.new_page(reduced_motion="reduce", viewport={"width": 390, "height": 844})
    open_goal(other, gateway, goal_id)
    notes, others = (each.get_by_role("region", name="Notes") for each in (page, other))
    notes.get_by_label("New note").fill("wheel was blocked\nby a box")
    notes.get_by_label("Your name").fill("Ada")
    press(page, "Add note")
    notes.get_by_role("combobox", name="Tags").fill("blocked")
    page.keyboard.press("Enter")
    for each in (notes, others):
        expect(each.get_by_role("listitem")).to_have_text(re.compile("Ada.*wheel was blocked\nby a box", re.DOTALL))
        expect(each.get_by_text("blocked", exact=True)).to_be_visible()
    assert find_violations(page) == []
    page.get_by_role("link", name="Goals", exact=True).first.click()
    expect(page.get_by_role("link", name="blocked")).to_have_count(1)
    page.get_by_label("Tag", exact=True).select_option("blocked")
    expect(page).to_have_url(re.compile(r"\?tag=blocked$"))
    rows = page.get_by_role("table").locator("tbody tr")
    expect(rows).to_have_count(1)
    (row,) = csv.DictReader(io.StringIO(export(page, "CSV")))
    assert (row["goal_id"], row["tags"]) == (goal_id, "blocked")
    rows.get_by_role("link").first.click()
    expect(page.get_by_test_id("feedback-table")).to_be_visible()
    press(page, "Delete the note by Ada")
    press(page, "Keep")
    press(page, "Delete the note by Ada")
    press(page, "Really delete the note by Ada")
    for each in (notes, others):
        expect(each.get_by_role("listitem")).to_have_count(0)
    other.close()


def test_a_goal_of_somebody_else(page: Page, gateway: RunningGateway, domain: int) -> None:
    page.goto(f"{gateway.url}/ui/goals?origin=external")
    with client_process(domain, "fibonacci_action_client", "--order", "46"):
        row = page.get_by_role("table").locator("tbody tr").first
        expect(row).to_contain_text(re.compile("/fibonacci.*executing.*external"))
        row.click()
        expect_status(page, "executing")
        again = page.get_by_role("button", name="Send again …")
        expect(again).to_be_disabled()
        missing = "The goal's message is missing: ROS does not tell what others asked for."
        expect(again).to_have_accessible_description(missing)
        expect(page.get_by_test_id("feedback-table").locator("tbody tr").nth(2)).to_be_visible()
        press(page, "Cancel")
        expect_status(page, "canceled")


def test_accessibility(page: Page, gateway: RunningGateway) -> None:
    goal_id = docking(gateway)
    page.goto(f"{gateway.url}/ui/goals")
    expect(page.get_by_role("table").locator("tbody tr").first).to_be_visible()
    assert find_violations(page) == []
    open_goal(page, gateway, goal_id)
    expect(page.get_by_test_id("feedback-table")).to_be_visible()
    assert find_violations(page) == []
    press(page, "Cancel")
    expect_status(page, "canceled")
    expect(page.get_by_role("region", name="Replay")).to_be_visible()
    assert find_violations(page) == []
    press(page, "Send again …")
    expect(page.get_by_role("dialog", name="Send this goal again?")).to_be_visible()
    assert find_violations(page) == []


@pytest.mark.parametrize("width", [320, 820])
def test_a_narrow_window(page: Page, gateway: RunningGateway, width: int) -> None:
    """At 320 CSS pixels nothing is cut off or scrolled sideways (WCAG 1.4.10)."""
    goal_id = docking(gateway)
    page.set_viewport_size({"width": width, "height": 1000})
    page.goto(f"{gateway.url}/ui/goals")
    expect(page.get_by_role("table").locator("tbody tr").first).to_be_visible()
    expect_no_sideways_scrolling(page)
    open_goal(page, gateway, goal_id)
    expect(page.get_by_test_id("feedback-table")).to_be_visible()
    expect_no_sideways_scrolling(page)
    press(page, "Cancel")
    expect(page.get_by_role("region", name="Replay")).to_be_visible()
    expect_no_sideways_scrolling(page)


def test_by_keyboard_alone(page: Page, gateway: RunningGateway) -> None:
    goal_id = docking(gateway)
    page.goto(f"{gateway.url}/ui/goals?status=running")
    link = page.get_by_role("table").get_by_role("link")
    expect(link).to_have_count(1)
    link.focus()
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile(goal_id))
    expect_status(page, "executing")
    page.get_by_role("button", name="Cancel", exact=True).focus()
    page.keyboard.press("Enter")
    expect_status(page, "canceled")

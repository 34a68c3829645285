"""A simulated robot on the dashboard: docked, undocked, stopped, placed and broken by clicking."""

import re
from collections.abc import Iterator
from contextlib import ExitStack
from math import hypot
from typing import NamedTuple

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.axe import SETTLED, find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.docking import FAST, PATIENT, UNMEASURED
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.waiting import wait_until

# A start that is near the dock, and no patience: nobody wants to watch for minutes.
NEAR = ("-p", FAST, "-p", "start_x:=-1.1", "-p", "start_y:=0.1", "-p", "start_theta:=-0.1")
IMPATIENT = ("-p", "controller:=dock_pose", "-p", "max_retries:=1", "-p", "wait_charge_timeout:=1.5")
STEADY = ("-p", PATIENT, "-p", UNMEASURED)
# A goal looks for a marker that is hidden for as long as a test needs.
SEARCHING = ("-p", "initial_perception_timeout:=3600.0")
# How far before a robot its knob is drawn, by which it is turned.
KNOB_PX = 25
MINUS = "\N{MINUS SIGN}"
WORDS = re.compile(rf"x ({MINUS}?[\d.]+) m, y ({MINUS}?[\d.]+) m, heading ({MINUS}?\d+)°")
FIND_ROBOT = """(canvas) => {
    // The middle of all that has the robot's colour (the light scheme's), in CSS pixels of the page.
    const {data, width, height} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let [sumX, sumY, count] = [0, 0, 0];
    for (let index = 0; index < width * height; index += 1) {
        const [red, green, blue, alpha] = data.subarray(4 * index, 4 * index + 4);
        if (red !== 0x18 || green !== 0x64 || blue !== 0xab || alpha !== 255) continue;
        [sumX, sumY, count] = [sumX + (index % width), sumY + Math.floor(index / width), count + 1];
    }
    const box = canvas.getBoundingClientRect();
    return {x: box.left + (sumX / count) * (box.width / width), y: box.top + (sumY / count) * (box.height / height)};
}"""


class Pose(NamedTuple):
    """Where the page says that the robot is: m, and degrees."""

    x: float
    y: float
    heading: float


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator", *NEAR))
        stack.enter_context(running_program(domain, "docking_server", *IMPATIENT, *STEADY, *SEARCHING))
        gateway = stack.enter_context(running_gateway(domain))
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        yield gateway


@pytest.fixture
def page(page: Page, gateway: RunningGateway) -> Iterator[Page]:
    """The dashboard with the robot in sight, at its start."""
    gateway.http.post("/simulator/reset").raise_for_status()
    expect(page.get_by_text("Drag the robot to another place")).to_be_visible()
    expect(page.get_by_test_id("scene-words")).to_contain_text("Not docked")
    yield page
    gateway.stop_once()


def press(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def pose_in_words(page: Page) -> Pose:
    match = WORDS.search(page.get_by_test_id("scene-words").inner_text())
    assert match
    return Pose(*(float(number.replace(MINUS, "-")) for number in match.groups()))


def expect_status(page: Page, status: str) -> None:
    expect(page.get_by_test_id("goal-status")).to_have_text(status)


def open_tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name).press("Enter")  # a click would miss it where an alert appears above
    expect(page.get_by_role("tabpanel", name=name)).to_be_visible()


def robot_in_the_room(page: Page) -> dict[str, float]:
    """Where the robot is drawn once the whole room is shown, which has the dock at its right; in CSS pixels.

    It looks to the right, and so does the knob before it.
    """
    scene = page.get_by_test_id("scene")
    last: dict[str, float] = {}

    def find() -> dict[str, float] | None:
        box, drawn = scene.bounding_box(), scene.evaluate(FIND_ROBOT)
        stands = drawn == last
        last.update(drawn)
        return drawn if box and stands and drawn["x"] > box["x"] + 0.6 * box["width"] else None

    found = wait_until(find, "the robot in its room")
    assert found
    return {"x": found["x"] - KNOB_PX / 2, "y": found["y"]}


def off_the_middle(page: Page) -> float:
    """How far from the middle of the map the robot is drawn, with the knob before it, in CSS pixels."""
    scene = page.get_by_test_id("scene")
    robot, box = scene.evaluate(FIND_ROBOT), scene.bounding_box()
    assert box is not None
    return hypot(robot["x"] - box["x"] - box["width"] / 2, robot["y"] - box["y"] - box["height"] / 2)


def top(locator: Locator) -> float:
    """How far below the window's upper edge something begins, in CSS pixels."""
    box = locator.bounding_box()
    assert box is not None
    return box["y"]


def start_docking(page: Page) -> None:
    dock = page.get_by_role("button", name="Dock", exact=True)
    expect(dock).to_be_enabled()
    dock.press("Enter")  # a click would miss it while the stop's banner goes away above


def start_searching(page: Page, gateway: RunningGateway) -> None:
    """A goal that runs until it is stopped."""
    gateway.set_fault("occluded_marker")
    start_docking(page)
    wait_until(lambda: gateway.http.get("/goals?status=executing").json()["goals"], "a goal that runs")
    expect(page.get_by_test_id("stages").get_by_role("listitem").filter(has_text="now")).to_be_visible()


def test_dock_and_undock(page: Page, gateway: RunningGateway) -> None:
    start_searching(page, gateway)
    expect(page.get_by_role("button", name="Undock")).to_have_accessible_description(
        "A goal is running. Cancel it first."
    )
    gateway.set_fault("occluded_marker", active=False)
    expect_status(page, "succeeded")
    expect(page.get_by_test_id("scene-words")).to_contain_text("Docked.")
    expect(page.get_by_test_id("battery-status")).to_have_text("Charging")
    assert gateway.http.get("/simulator").json()["docked"] is True
    press(page, "Undock")
    expect(page.get_by_text("Last goal: undock")).to_be_visible()
    expect_status(page, "succeeded")
    expect(page.get_by_test_id("scene-words")).to_contain_text("Not docked")
    expect(page.get_by_test_id("battery-status")).not_to_have_text("Charging")
    expect(page.get_by_role("row").filter(has_text="Left the dock")).to_be_visible()


def test_a_goal_is_replayed_on_the_map(page: Page, gateway: RunningGateway) -> None:
    goal = gateway.http.post("/dock", headers={"Prefer": "wait=90"}, timeout=100).raise_for_status().json()
    assert goal["status"] == "succeeded"
    page.goto(f"{gateway.url}/ui/goals/{goal['goal_id']}")
    words = page.get_by_test_id("replay-map-words")

    def x() -> float:
        match = WORDS.search(words.inner_text())
        assert match
        return float(match.group(1).replace(MINUS, "-"))

    expect(words).to_have_text(WORDS)
    assert x() > -0.3, "at its dock in the end"
    scrubber = page.get_by_role("slider", name="Moment of the goal")
    scrubber.focus()
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    wait_until(lambda: x() < -0.9, "the robot where it began")
    drawn = page.get_by_test_id("scene").evaluate(FIND_ROBOT)
    assert drawn["x"] > 0, "the robot is in the picture"
    press(page, "Play")
    wait_until(lambda: x() > -0.9, "the robot on its way")
    assert find_violations(page) == []


def test_the_robot_is_followed(page: Page, gateway: RunningGateway) -> None:
    follow = page.get_by_role("button", name="Follow the robot")
    expect(follow).to_have_attribute("aria-pressed", "false")
    follow.click()
    expect(follow).to_have_attribute("aria-pressed", "true")
    place = {"x": -2.0, "y": -0.5, "theta": 0.3}
    gateway.http.post("/simulator/place", json=place).raise_for_status()
    wait_until(lambda: off_the_middle(page) < KNOB_PX, "the robot in the middle")
    page.reload()
    expect(follow).to_have_attribute("aria-pressed", "true")
    # The plots of the battery have a button of the same name.
    page.get_by_role("region", name="Map").get_by_role("button", name="Closer", exact=True).click()
    wait_until(lambda: off_the_middle(page) < KNOB_PX, "the robot in the middle after a reload")
    assert find_violations(page) == []
    page.get_by_test_id("scene").focus()
    page.keyboard.press("Control+ArrowRight")
    expect(follow).to_have_attribute("aria-pressed", "false")
    page.reload()
    expect(follow).to_have_attribute("aria-pressed", "false")


def test_stop_by_keyboard_and_release(page: Page, gateway: RunningGateway) -> None:
    start_searching(page, gateway)
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    expect(page.get_by_test_id("stop-banner")).to_contain_text("Robot stopped by the dashboard")
    expect_status(page, "canceled")
    expect(page.get_by_text("Canceled by a stop. A stop was requested by the dashboard.")).to_be_visible()
    expect(page.get_by_test_id("stages").get_by_text("did not work")).to_have_count(0)
    assert gateway.http.get("/stop").json()["latched"] is True
    dock = page.get_by_role("button", name="Dock", exact=True)
    expect(dock).to_be_disabled()
    expect(dock).to_have_accessible_description("The robot is stopped. Release the stop first.")
    press(page, "Release …")
    page.get_by_role("dialog", name="Release the stop?").get_by_role("button", name="Release").click()
    expect(page.get_by_test_id("stop-banner")).to_be_hidden()
    assert gateway.http.get("/stop").json()["latched"] is False
    start_searching(page, gateway)


def test_a_stop_of_somebody_else(page: Page, gateway: RunningGateway) -> None:
    gateway.http.post("/stop", json={"by": "Ada"}).raise_for_status()
    expect(page.get_by_test_id("stop-banner")).to_contain_text("Robot stopped by Ada at")
    page.reload()
    expect(page.get_by_test_id("stop-banner")).to_contain_text("Robot stopped by Ada at")
    gateway.http.delete("/stop").raise_for_status()
    expect(page.get_by_test_id("stop-banner")).to_be_hidden()


def test_stop_without_a_stream(page: Page, gateway: RunningGateway) -> None:
    page.route_web_socket("**/ws/feedback*", lambda socket: socket.close())
    page.reload()
    expect(page.get_by_test_id("connection")).not_to_have_text("live")
    press(page, "Stop")
    expect(page.get_by_test_id("stop-banner")).to_be_visible()
    stop = gateway.http.get("/stop").json()
    assert (stop["latched"], stop["by"], stop["robots"]) == (True, "the dashboard", ["/"])


def test_place_by_drag(page: Page) -> None:
    before = pose_in_words(page)
    robot = robot_in_the_room(page)
    page.mouse.move(robot["x"], robot["y"])
    page.mouse.down()
    page.mouse.move(robot["x"] + 30, robot["y"] + 60, steps=4)
    page.mouse.up()
    wait_until(lambda: pose_in_words(page).y < before.y - 0.1, "the robot where it was dragged")
    after = pose_in_words(page)
    assert after.x > before.x + 0.05
    assert after.heading == before.heading
    assert (before.y - after.y) / (after.x - before.x) == pytest.approx(2.0, abs=0.15)


def test_a_fault_ends_the_goal_with_its_code(page: Page) -> None:
    open_tab(page, "Developer")
    fault = page.get_by_role("switch", name="Dead charger")
    fault.press("Space")
    expect(fault).to_be_checked()
    open_tab(page, "Operate")
    start_docking(page)
    expect(page.get_by_test_id("retries")).to_have_text("1 retry")
    expect_status(page, "aborted")
    alert = page.get_by_role("alert").filter(has_text="failed_to_charge")
    expect(alert).to_contain_text("look at the dock's power")
    expect(page.get_by_test_id("stages").get_by_role("listitem").last).to_contain_text("did not work")
    open_tab(page, "Developer")
    press(page, "Reset")
    expect(fault).not_to_be_checked()


def test_accessibility(page: Page, gateway: RunningGateway) -> None:
    start_searching(page, gateway)
    assert find_violations(page) == []
    press(page, "Stop")
    expect(page.get_by_test_id("stop-banner")).to_be_visible()
    assert find_violations(page) == []
    press(page, "Release …")
    expect(page.get_by_role("dialog", name="Release the stop?")).to_be_visible()
    assert find_violations(page) == []
    press(page, "Keep it stopped")
    expect(page.get_by_role("dialog")).to_be_hidden()
    open_tab(page, "Developer")
    expect(page.get_by_role("region", name="Simulator", exact=True)).to_be_visible()
    assert find_violations(page) == []
    press(page, "Keyboard and name")
    expect(page.get_by_role("dialog", name="Keyboard and name")).to_be_visible()
    assert find_violations(page) == []


def test_stop_is_beside_an_open_dialog(page: Page) -> None:
    press(page, "Keyboard and name")
    dialog = page.get_by_role("dialog")
    expect(dialog).to_be_visible()
    page.evaluate(SETTLED)
    assert top(dialog) >= top(page.get_by_role("main"))
    press(page, "Stop")
    expect(page.get_by_test_id("stop-banner")).to_be_attached()


def test_a_phone(page: Page, gateway: RunningGateway) -> None:
    page.set_viewport_size({"width": 320, "height": 800})
    start_searching(page, gateway)
    press(page, "Stop")
    expect(page.get_by_test_id("stop-banner")).to_be_visible()
    expect_no_sideways_scrolling(page)
    open_tab(page, "Developer")
    expect(page.get_by_role("region", name="Simulator", exact=True)).to_be_visible()
    expect_no_sideways_scrolling(page)


def test_the_camera_is_read_while_it_is_in_sight(page: Page, gateway: RunningGateway) -> None:
    def readers() -> list[str]:
        topic = gateway.http.get("/graph/topics/camera/image_raw/compressed").raise_for_status().json()
        return [each["node"] for each in topic["subscribers"]]

    card = page.get_by_role("region", name="Camera", exact=True)
    switch = card.get_by_role("switch", name="Show")
    expect(card).to_contain_text("The camera is off")
    assert readers() == []
    switch.check()
    expect(card.get_by_text(re.compile(r"Hz · .* old · \d+ . \d+"))).to_be_visible()
    seen = card.get_by_role("img").evaluate(
        "(it) => new Set(it.getContext('2d').getImageData(0, 0, it.width, it.height).data).size"
    )
    assert seen > 20  # shades
    assert readers() == ["/dock_gateway"]
    open_tab(page, "Developer")
    wait_until(lambda: not readers(), "nobody looks")

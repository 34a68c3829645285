"""The page of a robot: its battery over time, its goal stage by stage, its battery's publisher."""

import re
from collections.abc import Iterator
from contextlib import ExitStack
from math import isnan, nan

import pytest
from playwright.sync_api import Locator, Page, expect
from sensor_msgs.msg import BatteryState

from tests.browser.axe import find_violations
from tests.support.docking import battery_state
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.observer import ros_observer
from tests.support.waiting import wait_until

pytestmark = needs("simulator")

NEAR = ("-p", "start_x:=-1.1", "-p", "start_y:=0.1", "-p", "start_theta:=-0.1")
# With a dead charger a goal waits on the dock for as long as a test needs.
SERVER = ("-p", "controller:=dock_pose", "-p", "wait_charge_timeout:=3600.0")
CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d")
VOLTS = re.compile(r"^\d+\.\d\d V")
TRAIL_LENGTH = """(canvas) => {
    // From the leftmost to the rightmost pixel that has the trail's colour (the light scheme's), in CSS pixels.
    const {data, width, height} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let [left, right] = [width, 0];
    for (let index = 0; index < width * height; index += 1) {
        const [red, green, blue] = data.subarray(4 * index, 4 * index + 3);
        if (red !== 0x4d || green !== 0xab || blue !== 0xf7) continue;
        [left, right] = [Math.min(left, index % width), Math.max(right, index % width)];
    }
    return (right - left) * canvas.getBoundingClientRect().width / width;
}"""


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator", *NEAR))
        stack.enter_context(running_program(domain, "docking_server", *SERVER))
        gateway = stack.enter_context(running_gateway(domain))
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        wait_until(lambda: len(gateway.http.get("/battery/history").json()["time"]) > 3, "a battery with a past")
        yield gateway


@pytest.fixture
def page(page: Page, gateway: RunningGateway) -> Page:
    """The robot's page, live, with the robot at its start."""
    gateway.http.post("/simulator/reset").raise_for_status()
    page.goto(f"{gateway.url}/ui/robot")
    expect(page.get_by_test_id("connection")).to_have_text("live")
    expect(page.get_by_test_id("scene-words")).to_contain_text("Not docked")
    return page


def press(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def open_tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name).press("Enter")  # a click would miss it where an alert appears above
    expect(page.get_by_role("tabpanel", name=name)).to_be_visible()


def expect_disabled(page: Page, name: str, reason: str) -> None:
    """A button is disabled, and says why: to a screen reader, and in a tooltip where the keyboard goes to it."""
    page.mouse.move(0, 0)  # over no other button
    expect(page.get_by_role("tooltip")).to_have_count(0)
    button = page.get_by_role("button", name=name, exact=True)
    expect(button).to_be_disabled()
    expect(button).to_have_accessible_description(reason)
    button.focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    expect(button).to_be_focused()
    expect(page.get_by_role("tooltip")).to_have_text([reason])  # alone, once that of the button before has closed
    button.blur()
    expect(page.get_by_role("tooltip")).to_have_count(0)


def plots(page: Page) -> Locator:
    """The plots, drawn."""
    expect(page.get_by_test_id("value-voltage")).to_have_text(VOLTS)
    plots = page.get_by_test_id("battery-plots")
    plots.scroll_into_view_if_needed()
    return plots


def shown(page: Page) -> str:
    return page.get_by_test_id("plot-range").inner_text()


def test_an_operator_sees_map_and_goal_without_scrolling(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    press(page, "Dock")
    for locator in (
        page.get_by_test_id("scene"),
        page.get_by_test_id("stages"),
        page.get_by_role("link", name="Goal details"),
        page.get_by_role("region", name="Battery", exact=True),
    ):
        expect(locator).to_be_in_viewport(ratio=1)
    boxes = [page.get_by_role("region", name=name, exact=True).bounding_box() for name in ("Docking", "Map")]
    docking, scene = boxes
    assert docking
    assert scene
    assert docking["y"] == scene["y"]
    assert docking["x"] + docking["width"] < scene["x"]


def test_the_developer_tab_stays_in_the_address_and_keeps_what_was_typed(page: Page) -> None:
    page.get_by_role("tab", name="Operate").focus()
    page.keyboard.press("ArrowRight")
    expect(page).to_have_url(re.compile(r"\?tab=developer$"))
    page.get_by_label("Voltage (V)").fill("3.3")
    open_tab(page, "Operate")
    expect(page).to_have_url(re.compile("/ui/robot$"))
    expect(page.get_by_test_id("scene")).to_be_visible()
    open_tab(page, "Developer")
    expect(page.get_by_label("Voltage (V)")).to_have_value("3.3")
    page.reload()
    expect(page.get_by_role("region", name="Simulator", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Dock", exact=True)).to_be_hidden()


def test_the_plots_are_live_and_can_be_paused(page: Page, gateway: RunningGateway) -> None:
    plots(page)
    assert shown(page) == "Last 5 min"
    press(page, "Pause")
    expect(page.get_by_test_id("plot-range")).to_have_text(re.compile(f"{CLOCK.pattern}.* to {CLOCK.pattern}"))
    paused, before = shown(page), page.get_by_test_id("value-temperature").inner_text()
    assert before.endswith("°C")
    wait_until(lambda: gateway.http.get("/battery").json()["age_s"] < 1, "a battery that goes on")
    assert shown(page) == paused
    press(page, "Go live")
    expect(page.get_by_test_id("plot-range")).to_have_text("Last 5 min")


def test_a_crosshair_over_all_plots(page: Page) -> None:
    over = plots(page).locator(".u-over").nth(2)
    box = over.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] - 2, box["y"] + box["height"] / 2)
    expect(page.get_by_test_id("plot-moment")).to_have_text(CLOCK)
    for crosshair in plots(page).locator(".u-cursor-x").all():
        expect(crosshair).to_be_visible()
    page.mouse.move(box["x"], box["y"] - 60)
    expect(page.get_by_test_id("plot-moment")).to_have_text("")


def test_closer_with_the_mouse_and_back(page: Page) -> None:
    box = plots(page).locator(".u-over").first.bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] * 0.9, y)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.95, y, steps=4)
    page.mouse.up()
    expect(page.get_by_test_id("plot-range")).to_contain_text(" to ")
    close = shown(page)
    page.mouse.dblclick(box["x"] + box["width"] / 2, y)
    expect(page.get_by_test_id("plot-range")).not_to_have_text(close)
    page.get_by_text("1 h", exact=True).click()
    expect(page.get_by_test_id("plot-range")).to_have_text("Last 1 h")
    expect(page.get_by_test_id("value-voltage")).to_have_text(VOLTS)


def test_the_wheel_alone_scrolls_the_page(page: Page) -> None:
    plots(page).hover()
    page.mouse.wheel(0, 100)
    wait_until(lambda: page.evaluate("window.scrollY") > 0, "a page that scrolled")
    assert shown(page) == "Last 5 min"
    page.keyboard.down("Control")
    page.mouse.wheel(0, 300)
    page.keyboard.up("Control")
    expect(page.get_by_test_id("plot-range")).not_to_have_text("Last 5 min")


def test_the_past_by_keyboard(page: Page) -> None:
    plots(page).focus()
    page.keyboard.press("ArrowLeft")
    expect(page.get_by_test_id("plot-moment")).to_have_text(CLOCK)
    expect(page.get_by_role("status").filter(has_text=re.compile(r"V, .* %, .* A, .* °C"))).to_be_attached()
    page.keyboard.press("-")
    expect(page.get_by_test_id("plot-range")).to_have_text("Last 10 min")
    page.keyboard.press("Shift+ArrowLeft")
    expect(page.get_by_test_id("plot-range")).to_contain_text(" to ")
    page.keyboard.press("0")
    expect(page.get_by_test_id("plot-range")).to_have_text("Last 5 min")
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Go live")).to_be_visible()


def test_publish_every_field_by_hand(page: Page, domain: int) -> None:
    open_tab(page, "Developer")
    press(page, "More fields")
    cells = page.get_by_role("group", name="Cell voltages (V)")
    for cell, voltage in ((1, "3.9"), (2, "")):
        cells.get_by_role("button", name="Add a cell").click()
        cells.get_by_label(f"cell {cell}").fill(voltage)
    page.get_by_label("Temperature (°C)", exact=True).fill("31.5")
    page.get_by_label("Location").fill("slot 1")
    with ros_observer(domain, "field_observer") as observer:
        states = observer.record(BatteryState, "/battery_status")  # the simulator may follow ours with one of its own
        publishers = observer.node.count_publishers
        wait_until(lambda: publishers("/battery_status") > 1, "the simulator and the gateway")

        def heard() -> BatteryState | None:
            press(page, "Publish once")  # again: DDS may know of a publisher before it hears it
            expect(page.get_by_text("Published once: 24 %, 2.16 V, not charging.")).to_be_visible()
            page.wait_for_timeout(500)
            return next((state for state in states.messages if state.location == "slot 1"), None)

        published = wait_until(heard, "the state that was published")
        assert published is not None
    assert (published.temperature, list(published.cell_voltage)) == (
        31.5,
        [pytest.approx(3.9), pytest.approx(nan, nan_ok=True)],
    )
    assert isnan(published.current)


def test_who_else_publishes(page: Page, domain: int) -> None:
    open_tab(page, "Developer")
    status, warning = page.get_by_test_id("publisher-status"), page.get_by_test_id("other-publishers")
    expect(status).to_contain_text("The simulator (/dock_simulator) publishes its battery.")
    press(page, "Publish repeatedly")
    expect(status).to_contain_text("This gateway publishes 24 %, 2.16 V, not charging at 1 Hz")
    expect(warning).to_be_hidden()
    with ros_observer(domain, "battery_driver") as driver, driver.publishing(battery_state(2), "/battery_status"):
        expect(warning).to_contain_text("/battery_driver publishes too")
        press(page, "Stop publishing")
        expect(warning).to_contain_text("/battery_driver publishes this battery")
    expect(warning).to_be_hidden()


def test_accessibility(page: Page) -> None:
    plots(page)
    press(page, "Pause")
    press(page, "More values")
    page.get_by_role("button", name="Cancel", exact=True).hover()
    expect(page.get_by_role("tooltip")).to_have_text("No goal is running.")
    assert find_violations(page) == []
    open_tab(page, "Developer")
    press(page, "More fields")
    page.get_by_role("button", name="Add a cell").first.click()
    assert find_violations(page) == []


def test_a_goal_stage_by_stage(page: Page, gateway: RunningGateway) -> None:
    """Nobody is asked about a simulated robot; who opens the page later sees what was before, too."""
    gateway.set_fault("dead_charger")
    expect(page.get_by_role("switch", name="off in simulation")).to_be_visible()
    press(page, "Dock")
    expect(page.get_by_role("dialog")).to_be_hidden()
    steps = page.get_by_test_id("stages").get_by_role("listitem")
    expect(steps.filter(has_text="Wait for charge: now")).to_be_visible()
    page.reload()
    wait_until(lambda: page.get_by_test_id("scene").evaluate(TRAIL_LENGTH) > 80, "0.3 m of trail, of before the reload")
    expect(steps.first).to_have_text(re.compile(r"Perception: done\d+(\.\d)? s$"))
    page.get_by_text("Feedback as it comes").click()
    expect(page.get_by_test_id("feedback-log").get_by_role("listitem").first).to_contain_text("not charging")
    gateway.set_fault("dead_charger", active=False)
    expect(page.get_by_test_id("goal-status")).to_have_text("succeeded")
    expect(steps.filter(has_text=re.compile(r"Controlling: done\d+(\.\d)? s$"))).to_be_visible()
    expect(page.get_by_test_id("stage-bar")).to_be_visible()
    page.get_by_role("link", name="Goal details").click()
    goal_id = gateway.http.get("/dock").json()["goals"][0]["goal_id"]
    expect(page).to_have_url(f"{gateway.url}/ui/goals/{goal_id}")


def test_one_robot_of_several(page: Page, gateway: RunningGateway, domain: int) -> None:
    """Its page is about it alone: its servers, its battery, its goals, its Stop."""
    with ExitStack() as stack:
        namespace = ("-r", "__ns:=/robot1")
        stack.enter_context(running_program(domain, "dock_simulator", *NEAR, *namespace))
        stack.enter_context(running_program(domain, "docking_server", *SERVER, *namespace))
        wait_until(lambda: gateway.http.get("/simulator?robot=/robot1").status_code == 200, "its simulator")
        gateway.set_fault("dead_charger", robot="/robot1")
        page.goto(f"{gateway.url}/ui/robot?robot=/robot1")
        expect(page.get_by_role("heading", name="/robot1", level=1)).to_be_visible()
        expect(page.get_by_test_id("action-server")).to_have_text("action server answering")
        plots(page)
        open_tab(page, "Developer")
        expect(page.get_by_test_id("publisher-status")).to_contain_text("/robot1/dock_simulator")
        expect(page.get_by_text(f"curl -sX POST '{gateway.url}/dock?robot=/robot1'", exact=True)).to_be_visible()
        open_tab(page, "Operate")
        page.get_by_role("switch", name="off in simulation").scroll_into_view_if_needed()
        press(page, "Dock")
        expect(page.get_by_test_id("stages").get_by_role("listitem").filter(has_text="now")).to_be_visible()
        goal = gateway.http.get("/dock?robot=/robot1").json()["goals"][0]
        press(page, "Stop /robot1")
        # A busy server may hear of the stop before the cancel request.
        expect(page.get_by_test_id("goal-status")).to_have_text(re.compile("canceled|aborted"))
        assert gateway.goal(goal["goal_id"])["status"] in {"canceled", "aborted"}
        held = gateway.http.get("/stop").json()
        assert (held["latched"], held["for_all"], held["robots"]) == (True, False, ["/robot1"])
        for verb in ("Dock", "Undock"):
            expect_disabled(page, verb, "The robot is stopped. Release the stop first.")
        expect(page.get_by_test_id("stop-banner")).to_contain_text("/robot1 stopped by the dashboard at")
        page.get_by_role("combobox", name="Switch robot").press_sequentially("Robot")
        page.keyboard.press("Enter")
        expect(page.get_by_role("heading", name="Robot", level=1, exact=True)).to_be_visible()
        expect(page.get_by_role("button", name="Dock", exact=True)).to_be_enabled()
        page.go_back()
        expect(page.get_by_role("heading", name="/robot1", level=1)).to_be_visible()
        expect(page.get_by_role("button", name="Dock", exact=True)).to_be_disabled()
        gateway.http.delete("/stop?robot=/robot1").raise_for_status()
        expect(page.get_by_role("button", name="Dock", exact=True)).to_be_enabled()

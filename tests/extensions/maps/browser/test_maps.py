"""The map under a robot: drawn from what ROS publishes, with docks that can be pressed."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Page, expect

from tests.browser.axe import find_violations
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = needs("simulator")

LAB = (-2.5, 1.6)
DOCKS = (
    *("-p", "controller:=dock_pose", "-p", "initial_perception_timeout:=3600.0", "-p", "docks:=[home, lab]"),
    *("-p", "home.frame:=map", "-p", "home.pose:=[-0.2, 0.0, 0.0]"),
    *("-p", "lab.frame:=map", "-p", f"lab.pose:=[{LAB[0]}, {LAB[1]}, 0.0]"),
)
# Around a map that is shown whole, in metres, as in `view.ts`.
MARGIN = 0.45
COUNT_WALLS = """(canvas) => {
    // How many pixels have the colour of what is occupied (the light scheme's).
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let at = 0; at < data.length; at += 4)
        if (data[at] === 0x86 && data[at + 1] === 0x8e && data[at + 2] === 0x96) count += 1;
    return count;
}"""


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator"))
        stack.enter_context(running_program(domain, "docking_server", *DOCKS))
        gateway = stack.enter_context(running_gateway(domain))
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        wait_until(lambda: len(gateway.http.get("/docks").json().get("docks", ())) == 2, "the docks")
        yield gateway
        gateway.stop_once()


def press_lab(page: Page, gateway: RunningGateway) -> None:
    """Press the dock `lab` on the whole map."""
    grid = gateway.http.get("/map").raise_for_status().json()["map"]
    width, height = (grid[side] * grid["resolution"] for side in ("width", "height"))
    middle = grid["origin"]["x"] + width / 2, grid["origin"]["y"] + height / 2
    box = page.get_by_test_id("scene").bounding_box()
    assert box is not None
    scale = min(box["width"] / (width + 2 * MARGIN), box["height"] / (height + 2 * MARGIN))
    x, y = LAB[0] + 0.26 - middle[0], LAB[1] - middle[1]
    page.mouse.click(box["x"] + box["width"] / 2 + x * scale, box["y"] + box["height"] / 2 - y * scale)


def test_a_dock_on_the_map_is_pressed(page: Page, gateway: RunningGateway) -> None:
    scene = page.get_by_test_id("scene")
    page.get_by_role("button", name="Whole map").click()
    wait_until(lambda: scene.evaluate(COUNT_WALLS) > 1000, "the walls")
    expect(page.get_by_text("laser scan")).to_be_visible()
    gateway.http.post("/stop", json={"by": "a test"}).raise_for_status()

    here = page.get_by_role("menuitem", name="Dock here")

    def is_refused() -> bool:
        """Press until it is the dock: the notice of the stop moves the map, and the floor is refused as well."""
        page.keyboard.press("Escape")
        press_lab(page, gateway)
        return here.filter(has_text="The robot is stopped. Release the stop first.").count() > 0

    wait_until(is_refused, "the menu, with the reason")
    expect(here).to_be_disabled()
    assert not find_violations(page)
    page.keyboard.press("Escape")
    gateway.http.delete("/stop").raise_for_status()
    expect(page.get_by_role("button", name="Dock", exact=True)).to_be_enabled()
    press_lab(page, gateway)
    here.click()
    goals = wait_until(lambda: gateway.http.get("/goals").json()["goals"], "the goal")
    assert goals[0]["goal"]["desired_battery_state"]["location"] == "lab"

"""The map of all robots: where they are, what is wrong with one, the way to its page, and who is not on it."""

import re
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import FloatRect, Page, expect

from tests.browser.axe import find_violations
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = needs("simulator")

STARTS = {"/robot1": (-1.0, 0.5, 0.0), "/robot2": (-2.5, -0.5, 1.57)}


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """Two simulated robots, and one that does not tell where it is."""
    with ExitStack() as stack:
        for robot, (x, y, theta) in STARTS.items():
            start = ("-p", f"start_x:={x}", "-p", f"start_y:={y}", "-p", f"start_theta:={theta}")
            stack.enter_context(running_program(domain, "dock_simulator", "-r", f"__ns:={robot}", *start))
        stack.enter_context(running_dock_server(domain, "-r", "__ns:=/robot3"))
        gateway = stack.enter_context(running_gateway(domain))
        for robot in STARTS:
            at = {"robot": robot}
            wait_until(lambda at=at: gateway.http.get("/simulator", params=at).status_code == 200, robot)
        wait_until(lambda: gateway.http.get("/docks", params={"robot": "/robot3"}).status_code == 200, "/robot3")
        label: dict[str, object] = {"display_name": "Left forklift", "groups": []}
        gateway.http.put("/label?robot=/robot2", json=label).raise_for_status()
        yield gateway


@pytest.fixture
def page(page: Page, gateway: RunningGateway) -> Iterator[Page]:
    """The map, with both robots on it."""
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Map").click()
    for robot in STARTS:
        expect(page.get_by_test_id(f"on map {robot}")).to_be_visible()
    yield page
    for robot in STARTS:
        gateway.http.delete("/stop", params={"robot": robot})


def box_of(page: Page, robot: str) -> FloatRect:
    """Where a robot is drawn."""
    box = page.get_by_test_id(f"on map {robot}").locator("svg").bounding_box()
    assert box is not None
    return box


def test_robots_are_where_they_are_and_lead_to_their_pages(page: Page, gateway: RunningGateway) -> None:
    def are_in_place() -> bool:  # the map grows when the second robot comes
        one, two = (box_of(page, robot) for robot in STARTS)
        right, up = one["x"] - two["x"], two["y"] - one["y"]
        return right == pytest.approx(1.5 * up, rel=0.05)

    wait_until(are_in_place, "1.5 m and 1 m apart")
    place = {"x": -1.0, "y": -0.5, "theta": 0.0}
    gateway.http.post("/simulator/place", params={"robot": "/robot1"}, json=place).raise_for_status()
    wait_until(lambda: abs(box_of(page, "/robot1")["y"] - box_of(page, "/robot2")["y"]) < 3, "the robot elsewhere")
    expect(page.get_by_test_id("on map /robot2")).to_have_text("Left forklift")
    page.get_by_role("link", name="/robot1").click()
    expect(page).to_have_url(re.compile(r"/ui/robot\?robot=/robot1$"))
    expect(page.get_by_role("heading", name="/robot1")).to_be_visible()


def test_what_is_wrong_and_who_is_missing(page: Page, gateway: RunningGateway) -> None:
    robot = page.get_by_test_id("on map /robot2")
    expect(robot).not_to_have_attribute("data-level", re.compile("."))
    gateway.http.post("/stop", params={"robot": "/robot2"}).raise_for_status()
    expect(robot).to_have_attribute("data-level", "critical")
    expect(robot).to_have_text("Left forkliftStopped")
    missing = page.get_by_role("list", name="Robots that are not on the map")
    expect(missing.get_by_role("listitem")).to_have_text(["/robot3No simulator, no odometry yet"])
    assert find_violations(page) == []


def test_a_robot_has_its_footprint(page: Page, domain: int) -> None:
    robot = page.get_by_test_id("on map /robot2").locator("svg")
    expect(robot).to_have_css("clip-path", re.compile("^circle"))
    footprint = "footprint:='[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]'"
    with running_dock_server(domain, "-r", "__ns:=/robot2", "-p", footprint):
        expect(robot).to_have_css("clip-path", re.compile("^polygon"))

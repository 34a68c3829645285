"""Every page that links lead to, at every width: nothing is cut off, lies on something else or leaves the window."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Page, expect

from tests.browser.layout import find_layout_faults, walk_pages
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway, running_talker
from tests.support.waiting import wait_until

ROBOTS = ("/warehouse_north/forklift_of_the_hall_17", "/robot2")
LABEL = "Forklift of the northern hall, number seventeen"
MOVING = """document.getAnimations().filter(({playState}) => playState === "running")
    .map(({animationName, transitionProperty}) => animationName ?? transitionProperty)"""
LOW = {"voltage": 20.1, "percentage": 0.12, "power_supply_status": 2}


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """Two robots, of which one has long names and a low battery, and what has happened to them."""
    with ExitStack() as stack:
        for robot in ROBOTS:
            stack.enter_context(running_dock_server(domain, "-r", f"__ns:={robot}"))
        stack.enter_context(running_talker(domain))
        gateway = stack.enter_context(running_gateway(domain))
        for robot in ROBOTS:
            at = {"robot": robot}
            wait_until(lambda at=at: gateway.http.get("/docks", params=at).status_code == 200, robot)  # type: ignore[misc]
            body = {"state": LOW, "rate_hz": 5}
            gateway.http.put("/battery/publisher", params=at, json=body).raise_for_status()
            goal = gateway.http.post("/dock", params=at).raise_for_status().json()["goal_id"]
            gateway.http.post(f"/dock/{goal}/cancel").raise_for_status()
            gateway.wait_for_goal(goal, "canceled")
        label: dict[str, object] = {"display_name": LABEL, "groups": ["Northern hall"]}
        gateway.http.put("/label", params={"robot": ROBOTS[0]}, json=label).raise_for_status()
        gateway.wait_until_stored()
        yield gateway


@pytest.fixture
def page(page: Page) -> Page:
    expect(page.get_by_test_id(f"robot {ROBOTS[0]}")).to_be_visible()
    return page


def faults_of(page: Page, *starts: str) -> list[str]:
    """What is wrong on pages, and what moves there although the system says that nothing should."""
    found = []
    for path in walk_pages(page, *starts):
        found += [f"{path} at {fault}" for fault in find_layout_faults(page)]
        found += [f"{path}: {name} moves" for name in page.evaluate(MOVING)]
    return found


def test_every_page(page: Page) -> None:
    faults = faults_of(page, "/", f"/ui/robot?robot={ROBOTS[0]}", "/ui/graph?view=list", "/ui/users", "/ui/tokens")
    assert not faults, "\n".join(faults)


def test_robots_that_are_stopped(page: Page, gateway: RunningGateway) -> None:
    for robot in ROBOTS:
        gateway.stop_once(f"?robot={robot}")
    try:
        for robot in ROBOTS:
            by = {"by": "Ada of the northern hall"}
            gateway.http.post("/stop", params={"robot": robot}, json=by).raise_for_status()
        expect(page.get_by_test_id("stop-banner")).to_contain_text("All 2 robots")
        faults = faults_of(page, "/", f"/ui/robot?robot={ROBOTS[0]}")
        assert not faults, "\n".join(faults)
    finally:
        for robot in ROBOTS:
            gateway.http.delete("/stop", params={"robot": robot})

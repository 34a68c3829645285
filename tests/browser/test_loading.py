"""What a first visit transfers, and that what is on the screen does not move while the page loads."""

import json
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.loading import WATCH, first_visit
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

MAX_BYTES = 320_000
MAX_SCRIPT_BYTES = 250_000
MAX_SHIFT = 0.02


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """A gateway that knows a simulated robot with its docking server: a page has all of it to show from the start."""
    with (
        running_program(domain, "dock_simulator"),
        running_program(domain, "docking_server"),
        running_gateway(domain) as gateway,
    ):
        gateway.wait_until_ready()
        wait_until(lambda: is_known(gateway), "the robot in GET /robots")
        yield gateway


def is_known(gateway: RunningGateway) -> bool:
    """Whether the docking server, the simulator and a battery state have been seen."""
    robots = gateway.http.get("/robots").json()["robots"]
    return any(
        robot["dock"]["available"] and robot["undock"]["available"] and robot["simulated"] and robot["battery"]["state"]
        for robot in robots
    )


@pytest.mark.parametrize("width", [1440, 768, 320])
def test_a_first_visit_is_small_and_does_not_move(browser: Browser, gateway: RunningGateway, width: int) -> None:
    visit = first_visit(browser, f"{gateway.url}/", width)
    assert 100_000 < visit.scripts < MAX_SCRIPT_BYTES
    assert visit.transferred < MAX_BYTES
    assert visit.shift < MAX_SHIFT, json.dumps(visit.moved, indent=2)


@needs("simulator")
def test_a_marker_that_is_detected_late_moves_nothing(browser: Browser, gateway: RunningGateway) -> None:
    def place(theta: float) -> None:
        gateway.http.post("/simulator/place", json={"x": -1.5, "y": 0.0, "theta": theta}).raise_for_status()

    with browser.new_context(viewport={"width": 390, "height": 1000}, reduced_motion="reduce") as context:
        page = context.new_page()
        page.add_init_script(WATCH)
        place(3.1)
        page.goto(gateway.url)
        legend = page.get_by_role("list", name="Legend")
        expect(legend).to_contain_text("infrared")
        expect(legend).not_to_contain_text("marker")
        before = legend.bounding_box()
        place(0.0)
        expect(legend).to_contain_text("marker as detected")
        after = legend.bounding_box()
        assert before is not None
        assert after is not None
        assert after["height"] == before["height"], json.dumps(page.evaluate("window.shifts"), indent=2)

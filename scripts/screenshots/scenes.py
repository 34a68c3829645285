#!/usr/bin/env python3
"""Take pictures of every page of the dashboard, in both colour schemes and three widths, with simulated robots.

With the virtual environment active: `scripts/screenshots` puts all of them into test-results/screenshots, `--docs`
renews those in docs/images, too.
"""

import argparse
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from playwright.sync_api import Browser, Page, expect, sync_playwright
from sensor_msgs.msg import BatteryState

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.browser.conftest import ARGUMENTS, CHROMIUM, MISSING  # noqa: E402
from tests.support.domain import ros_domain  # noqa: E402
from tests.support.gateway import RunningGateway, running_gateway, running_program  # noqa: E402
from tests.support.processes import BIN, Process, ros_environment  # noqa: E402
from tests.support.waiting import wait_until  # noqa: E402

IMAGES = ROOT / "docs/images"
MAX_BYTES = 300_000
START_S, DRIVE_S = 60.0, 90.0
SIZES = {"wide": (1440, 1000), "tablet": (820, 1180), "phone": (390, 844)}
SCHEMES = ("light", "dark")
NEAR = ("-p", "start_x:=-1.7", "-p", "start_y:=0.75", "-p", "start_theta:=0.1")
SERVER = ("-p", "controller:=dock_pose")
BUSY = "main [aria-busy=true], main .mantine-Skeleton-root"


class Picture(NamedTuple):
    """A picture for the documents: which page, in which scheme, how large."""

    page: str
    scheme: str
    width: int
    height: int


GOOD = {
    "dashboard.png": Picture("overview", "light", 1440, 900),
    "dashboard-dark.png": Picture("overview", "dark", 1440, 900),
    "dashboard-tablet.png": Picture("overview", "light", 820, 1180),
    "dashboard-phone.png": Picture("overview", "dark", 390, 844),
    "robot.png": Picture("developer", "light", 1440, 1000),
    "goals.png": Picture("goals", "light", 1440, 800),
    "statistics.png": Picture("statistics", "light", 1440, 800),
    "goal.png": Picture("goal", "dark", 1440, 1100),
    "action.png": Picture("action", "light", 1440, 900),
    "graph.png": Picture("graph", "light", 1440, 900),
    "graph-dark.png": Picture("graph", "dark", 1440, 900),
    "fleet.png": Picture("fleet", "light", 1440, 620),
    "fleet-phone.png": Picture("fleet", "dark", 390, 844),
}


class Camera:
    """Takes each page in every scheme and width.

    Args:
        browser: With it.
        gateway: Of it.
        folder: Where pictures of whole pages go.
        docs: Whether those for the documents are taken as well.
    """

    def __init__(self, browser: Browser, gateway: RunningGateway, folder: Path, *, docs: bool) -> None:
        self.page = browser.new_page(locale="en-GB", reduced_motion="reduce")
        self._url, self._folder, self._docs = gateway.url, folder, docs

    def open(self, path: str) -> Page:
        """Go to a page of the dashboard, and wait until it is live and has all that it shows."""
        self.page.goto(f"{self._url}{path}")
        expect(self.page.get_by_test_id("connection")).to_have_text("live", timeout=START_S * 1000)
        self._settle()
        return self.page

    def take(self, name: str) -> None:
        """Take the page that is open."""
        for file, picture in GOOD.items():
            if self._docs and picture.page == name:
                self._set(picture.scheme, picture.width, picture.height)
                self._shoot(IMAGES / file, whole=False)
        for size, (width, height) in SIZES.items():
            for scheme in SCHEMES:
                self._set(scheme, width, height)
                self._shoot(self._folder / f"{name}-{scheme}-{size}.png", whole=True)

    def _set(self, scheme: str, width: int, height: int) -> None:
        self.page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.mouse.move(0, 0)
        self.page.evaluate("window.scrollTo(0, 0)")
        expect(self.page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)
        self._settle()

    def _settle(self) -> None:
        expect(self.page.locator(BUSY)).to_have_count(0, timeout=START_S * 1000)
        self.page.wait_for_timeout(400)  # plots and pictures are drawn a moment after their data came

    def _shoot(self, path: Path, *, whole: bool) -> None:
        self.page.screenshot(path=path, animations="disabled", full_page=whole)
        size = path.stat().st_size
        if path.parent == IMAGES:
            assert size <= MAX_BYTES, f"{path} has {size} bytes"
        sys.stdout.write(f"{path}: {size // 1000} kB\n")


@contextmanager
def simulated(domain: int, *robots: tuple[str, ...]) -> Iterator[RunningGateway]:
    """A gateway over robots, each by the arguments of its simulator."""
    with ExitStack() as stack:
        for arguments in robots:
            namespace = tuple(text for text in arguments if text == "-r" or text.startswith("__ns"))
            stack.enter_context(running_program(domain, "dock_simulator", *arguments))
            stack.enter_context(running_program(domain, "docking_server", *SERVER, *namespace))
        stack.enter_context(running_program(domain, "fibonacci_action_server"))
        gateway = stack.enter_context(running_gateway(domain))
        wait_until(lambda: len(robots_of(gateway)) == len(robots), "every robot", START_S)
        yield gateway


def robots_of(gateway: RunningGateway) -> list[str]:
    """Names of the robots that can dock."""
    robots = gateway.http.get("/robots").json()["robots"]
    return [robot["name"] for robot in robots if robot["dock"] is not None and robot["battery"]["state"] is not None]


def send(gateway: RunningGateway, verb: str, query: str = "") -> str:
    """Send a goal; its id."""
    goal_id: str = gateway.http.post(f"/{verb}{query}").raise_for_status().json()["goal_id"]
    return goal_id


def wait_for(gateway: RunningGateway, goal_id: str, *statuses: str) -> None:
    """Wait until a goal on any action has one of the states."""
    wait_until(lambda: gateway.http.get(f"/goals/{goal_id}").json()["status"] in statuses, f"{statuses}", DRIVE_S)


def live_a_day(gateway: RunningGateway, domain: int, page: Page, seconds: float) -> str:
    """Let goals end as goals do, and name one that succeeded."""
    page.wait_for_timeout(0.4 * seconds * 1000)
    canceled = send(gateway, "dock")
    wait_for(gateway, canceled, "executing")
    gateway.http.post(f"/goals/{canceled}/cancel").raise_for_status()
    wait_for(gateway, canceled, "canceled")
    with Process(str(BIN / "connect_to_charging_dock_client"), env=ros_environment(domain)) as client:
        client.wait(DRIVE_S)
    page.wait_for_timeout(0.4 * seconds * 1000)
    undocked = send(gateway, "undock")
    wait_for(gateway, undocked, "succeeded")
    docked = dock_from_afar(gateway)
    wait_for(gateway, docked, "succeeded")
    wait_for(gateway, send(gateway, "undock"), "succeeded")
    page.wait_for_timeout(0.2 * seconds * 1000)
    return docked


def dock_from_afar(gateway: RunningGateway, query: str = "") -> str:
    """Place the robot some seconds from the dock, and send it there; the goal's id."""
    gateway.http.post(f"/simulator/place{query}", json={"x": -1.9, "y": 0.75, "theta": 0.1}).raise_for_status()
    # On a battery that still says that it is charging, the goal would succeed at once.
    wait_until(lambda: not is_charging(gateway, query), "a battery that is not charged", START_S)
    return send(gateway, "dock", query)


def is_charging(gateway: RunningGateway, query: str) -> bool:
    """Whether the robot's battery says so, as far as the gateway has heard."""
    state = gateway.http.get(f"/battery{query}").json()["state"]
    return state is None or state["power_supply_status"] == BatteryState.POWER_SUPPLY_STATUS_CHARGING


def one_robot(camera: Camera, gateway: RunningGateway, domain: int, seconds: float) -> None:
    """The pages as they are with one robot."""
    docked = live_a_day(gateway, domain, camera.open("/"), seconds)
    camera.open("/")
    goal = dock_from_afar(gateway)
    expect(camera.page.get_by_text("Driving to the staging pose").first).to_be_visible(timeout=START_S * 1000)
    camera.take("overview")
    wait_for(gateway, goal, "succeeded")
    camera.open("/ui/actions/fibonacci").get_by_role("button", name="Send goal").click()
    expect(camera.page.get_by_role("list", name="partial_sequence").get_by_role("listitem")).to_have_count(6)
    camera.take("action")
    for name, path in {
        "dock-action": "/ui/actions/connect_to_charging_dock",
        "developer": "/ui/robot?tab=developer",
        "actions": "/ui/actions",
        "goals": "/ui/goals",
        "statistics": "/ui/statistics",
        "goal": f"/ui/goals/{docked}",
        "graph-nodes": "/ui/graph?show=nodes&gateway=true",
        "graph-list": "/ui/graph?view=list",
        "no-page": "/ui/nothing",
    }.items():
        camera.open(path)
        camera.take(name)
    camera.open("/ui/graph?selected=topic:/battery_status&echo=true")
    expect(camera.page.get_by_role("region", name="Live messages")).to_contain_text(" Hz")
    camera.take("graph")
    camera.page.get_by_role("button", name="Keyboard and name").click()
    camera.take("keyboard")


def several_robots(camera: Camera, gateway: RunningGateway) -> None:
    """The overview: one robot docks, one is docked, one has a low battery."""
    wait_for(gateway, send(gateway, "dock", "?robot=/robot2"), "succeeded")
    wait_until(lambda: gateway.http.get("/alerts").json()["alerts"], "an alert", START_S)
    camera.open("/")
    dock_from_afar(gateway, "?robot=/robot1")
    expect(camera.page.get_by_role("table")).to_contain_text("Dock: Staging")
    camera.take("fleet")
    camera.open("/ui/robot?robot=/robot1")
    camera.take("fleet-robot")


def main() -> None:
    """Take them all."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "test-results/screenshots", help="where they go")
    parser.add_argument("--docs", action="store_true", help="renew those in docs/images, too")
    parser.add_argument("--seconds", type=float, default=240.0, help="of battery data in the plots")
    arguments = parser.parse_args()
    if CHROMIUM is None:
        sys.exit(MISSING)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    with (
        sync_playwright() as playwright,
        playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS) as browser,
    ):
        with ros_domain() as domain, simulated(domain, NEAR) as gateway:
            camera = Camera(browser, gateway, arguments.folder, docs=arguments.docs)
            one_robot(camera, gateway, domain, arguments.seconds)
        charged = {"/robot1": 0.4, "/robot2": 0.6, "/robot3": 0.12}
        fleet = [("-r", f"__ns:={name}", *NEAR, "-p", f"battery_start:={charge}") for name, charge in charged.items()]
        with ros_domain() as domain, simulated(domain, *fleet) as gateway:
            several_robots(Camera(browser, gateway, arguments.folder, docs=arguments.docs), gateway)


if __name__ == "__main__":
    main()

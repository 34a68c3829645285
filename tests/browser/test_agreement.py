"""Whatever fails, every page and the API say the same of a goal, a robot and the connection."""

import re
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect

from tests.browser.conftest import PATIENCE_MS
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway, running_program
from tests.support.installed import needs
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = needs("simulator")

ROBOT, OTHER = "/robot1", "/robot2"
AT = {"robot": ROBOT}
NAMESPACE = ("-r", f"__ns:={ROBOT}")
# A dead charger and a patient server: a goal runs until the test ends it, however slow the pages are.
FAR = (*NAMESPACE, "-p", "start_x:=-3.0")
SERVER = (*NAMESPACE, "-p", "wait_charge_timeout:=3600.0")
IMPATIENT = {"ping_interval": "0.5", "stalled_after": "1.5", "lost_after": "3"}
# Shifts the browser's clock by so many ms.
CLOCK = """{
    const Real = Date;
    globalThis.clockShift = SHIFT;
    globalThis.Date = class extends Real {
        constructor(...given) { given.length === 0 ? super(Date.now()) : super(...given); }
        static now() { return Real.now() + globalThis.clockShift; }
    };
    Object.defineProperty(performance, "timeOrigin", { value: performance.timeOrigin + SHIFT });
}"""
HOUR_MS = 3_600_000
SLOW = {"offline": False, "latency": 300, "downloadThroughput": 100_000, "uploadThroughput": 50_000}


@dataclass
class Site:
    """A gateway, a robot that is simulated with its docking server, and another robot."""

    gateway: RunningGateway
    simulator: Process
    server: Process
    domain: int
    database: str

    def dock(self, name: str = ROBOT) -> str:
        """Send a robot to its dock, far away."""
        return str(self.gateway.http.post("/dock", params={"robot": name}).raise_for_status().json()["goal_id"])

    def robot(self, name: str = ROBOT) -> dict[str, Any]:
        robots = self.gateway.http.get("/robots").raise_for_status().json()["robots"]
        return next(robot for robot in robots if robot["name"] == name)


@pytest.fixture(scope="module")
def lasting_site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("site")) as site:
        yield site


@pytest.fixture
def site(lasting_site: Site) -> Iterator[Site]:
    """One that nothing happens to. It is left without a goal and without a stop."""
    yield lasting_site
    lasting_site.gateway.http.delete("/stop").raise_for_status()
    lasting_site.gateway.stop_once()


@contextmanager
def running_site(folder: Path) -> Iterator[Site]:
    with ros_domain() as domain, ExitStack() as stack:
        simulator = stack.enter_context(running_program(domain, "dock_simulator", *FAR))
        server = stack.enter_context(running_program(domain, "docking_server", *SERVER))
        stack.enter_context(running_dock_server(domain, "-r", f"__ns:={OTHER}"))
        database = f"sqlite:///{folder}/history.db"
        gateway = stack.enter_context(running_gateway(domain, database_url=database, **IMPATIENT))
        for name in (ROBOT, OTHER):
            wait_until(lambda name=name: gateway.http.get("/docks", params={"robot": name}).status_code == 200, name)
        wait_until(lambda: gateway.http.get("/simulator", params=AT).status_code == 200, "the simulator")
        gateway.set_fault("dead_charger", robot=ROBOT)
        yield Site(gateway, simulator, server, domain, database)


@dataclass
class Views:
    """The overview, the robot's page, the list of goals and a goal's page, open side by side."""

    site: Site
    goal_id: str
    overview: Page
    robot: Page
    goals: Page
    goal: Page
    name: str = ROBOT

    @property
    def all(self) -> tuple[Page, ...]:
        return self.overview, self.robot, self.goals, self.goal

    @property
    def row(self) -> Locator:
        return self.overview.get_by_test_id(f"robot {self.name}")

    def expect_goal(self, status: str) -> None:
        """Every page and the API agree on how the goal stands."""
        row = self.goals.get_by_role("table").locator("tbody tr").first
        expect(self.goal.get_by_test_id("goal-status")).to_have_text(status, ignore_case=True)
        expect(self.robot.get_by_test_id("goal-status")).to_have_text(status, ignore_case=True)
        expect(row).to_contain_text(status, ignore_case=True)
        assert self.site.gateway.goal(self.goal_id)["status"] == status

    def expect_live(self) -> None:
        for page in self.all:
            expect(page.get_by_test_id("connection")).to_have_text("live")


@contextmanager
def views(browser: Browser | BrowserContext, site: Site, goal_id: str, name: str = ROBOT) -> Iterator[Views]:
    with ExitStack() as stack:
        if isinstance(browser, Browser):
            browser = stack.enter_context(browser.new_context(reduced_motion="reduce"))
        pages = []
        for path in ("", f"ui/robot?robot={name}", "ui/goals", f"ui/goals/{goal_id}"):
            page = stack.enter_context(browser.new_page())
            page.set_default_timeout(PATIENCE_MS)
            page.goto(f"{site.gateway.url}/{path}")
            pages.append(page)
        seen = Views(site, goal_id, *pages, name=name)
        seen.expect_live()
        yield seen


def test_two_browsers_one_of_them_far_away(browser: Browser, site: Site) -> None:
    with views(browser, site, site.dock()) as near, browser.new_page(reduced_motion="reduce") as far:
        far.set_default_timeout(PATIENCE_MS)
        far.goto(f"{site.gateway.url}/ui/robot?robot={ROBOT}")
        far.context.new_cdp_session(far).send("Network.emulateNetworkConditions", SLOW)
        far.reload()
        expect(far.get_by_test_id("goal-status")).to_have_text("executing")
        far.get_by_role("button", name="Stop", exact=True).click()
        near.expect_goal("canceled")
        expect(near.row).to_contain_text("Stopped")
        expect(far.get_by_test_id("goal-status")).to_have_text("canceled")
        for page in (far, *near.all):
            expect(page.get_by_test_id("stop-banner")).to_contain_text("All robots stopped by the dashboard")
        far.get_by_role("button", name="Release …").click()
        far.get_by_role("dialog").get_by_role("button", name="Release").click()
        for page in (far, *near.all):
            expect(page.get_by_test_id("stop-banner")).to_be_hidden()


@pytest.mark.parametrize("shift", [-HOUR_MS, HOUR_MS], ids=["behind", "ahead"])
def test_the_clock_of_the_browser_is_wrong_and_then_corrected(browser: Browser, site: Site, shift: int) -> None:
    with browser.new_context(reduced_motion="reduce") as context:
        context.add_init_script(CLOCK.replace("SHIFT", str(shift)))
        with views(context, site, site.dock()) as seen:
            seen.expect_goal("executing")
            expect(seen.row).to_contain_text(re.compile("%.*now.*Dock: .*Connected"))
            expect(seen.robot.get_by_role("main")).not_to_contain_text("Stale")
            expect(seen.goal.get_by_role("main")).to_contain_text(re.compile(r"\d s\b"))
            expect(seen.goal.get_by_role("main")).not_to_contain_text(re.compile(r"59 min|\b1 h"))
            for page in seen.all:
                page.evaluate("globalThis.clockShift = 0")
            site.gateway.http.post(f"/dock/{seen.goal_id}/cancel").raise_for_status()
            seen.expect_goal("canceled")
            expect(seen.goal.get_by_role("main")).not_to_contain_text(re.compile(r"59 min|\b1 h"))
            assert not site.robot()["battery"]["stale"]


def test_a_robot_without_a_simulator(browser: Browser, site: Site) -> None:
    http, at = site.gateway.http, {"robot": OTHER}
    with views(browser, site, site.dock(OTHER), OTHER) as seen:
        seen.expect_goal("executing")
        main = seen.robot.get_by_role("main")
        expect(main).to_contain_text("No battery state yet")
        expect(main).to_contain_text("Nothing to draw yet")
        expect(seen.row).not_to_contain_text("%")
        assert http.get("/simulator", params=at).json()["code"] == "simulator_not_found"
        low = {"percentage": 0.24, "power_supply_status": "DISCHARGING"}
        http.put("/battery/publisher", params=at, json={"state": low, "rate_hz": 5}).raise_for_status()
        expect(main).to_contain_text("24 %")
        expect(seen.row).to_contain_text(re.compile("24 %.*now.*Dock: .*Connected"))
        charging = {"percentage": 0.25, "power_supply_status": "CHARGING"}
        http.put("/battery/publisher", params=at, json={"state": charging, "rate_hz": 5}).raise_for_status()
        seen.expect_goal("succeeded")
        expect(seen.row).to_contain_text(re.compile("25 %.*Charging", re.IGNORECASE))
        seen.robot.get_by_role("tab", name="Developer").click()
        expect(main).to_contain_text("Publish a battery state")
        expect(main).not_to_contain_text("Simulator")
        http.delete("/battery/publisher", params=at).raise_for_status()
        expect(seen.row).to_contain_text("ago")


def test_the_gateway_the_docking_server_and_the_robot_are_killed(browser: Browser, tmp_path: Path) -> None:
    with running_site(tmp_path) as site, views(browser, site, site.dock()) as seen:
        seen.expect_goal("executing")
        for page in seen.all:  # a part that is still loading when the gateway is killed has to be loaded again
            page.wait_for_load_state("networkidle")
        kill_gateway(seen)
        port = site.gateway.url.rpartition(":")[2]
        with running_gateway(site.domain, port=port, database_url=site.database, **IMPATIENT) as site.gateway:
            seen.expect_live()
            seen.expect_goal("executing")
            expect(seen.row).to_contain_text("Connected")
            kill_docking_server(seen)
            kill_robot(seen)
            seen.expect_goal("lost")
            seen.expect_live()


def kill_gateway(seen: Views) -> None:
    seen.site.gateway.process.send_signal(signal.SIGKILL)
    for page in seen.all:
        expect(page.get_by_test_id("connection")).not_to_have_text("live")
    expect(seen.row).to_contain_text("Not live")
    expect(seen.robot.get_by_role("button", name="Dock", exact=True)).to_be_disabled()
    seen.site.gateway.process.wait()


def kill_docking_server(seen: Views) -> None:
    seen.site.server.send_signal(signal.SIGKILL)
    seen.expect_goal("lost")
    expect(seen.row).to_contain_text("No docking server")
    expect(seen.row).not_to_contain_text("Connected")
    for page in seen.all:
        expect(page.get_by_test_id("alert-count")).to_contain_text("1 alert")
    expect(seen.robot.get_by_role("button", name="Dock", exact=True)).to_be_disabled()
    robot = seen.site.robot()
    assert not robot["dock"]["available"]
    assert robot["last_goal"]["status"] == "lost"


def kill_robot(seen: Views) -> None:
    seen.site.simulator.send_signal(signal.SIGKILL)
    expect(seen.row).to_contain_text("Unreachable")
    expect(seen.row).to_contain_text("ago")
    expect(seen.robot.get_by_role("main")).to_contain_text("Unreachable")
    expect(seen.robot.get_by_role("main")).to_contain_text("Stale")
    expect(seen.overview.get_by_test_id(f"robot {OTHER}")).to_contain_text("Connected")
    assert seen.site.robot()["battery"]["stale"]


def test_a_hundred_robots(browser: Browser) -> None:
    crowd = ("-m", "tests.support.robots", "--robots", "100")
    with ros_domain() as domain, ForkedProcess(*crowd, env=ros_environment(domain)), running_gateway(domain) as gateway:
        wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) == 101, "a hundred robots and our own")
        with browser.new_page(viewport={"width": 1440, "height": 900}) as page:
            page.goto(gateway.url)
            page.set_default_timeout(PATIENCE_MS)
            expect(page.get_by_role("button", name="100 All")).to_be_visible()
            page.goto(f"{gateway.url}/?sort=name&order=desc")
            expect(page.get_by_test_id("robot /robot100")).to_contain_text(re.compile("50 %.*now"))
            gateway.http.post("/stop").raise_for_status()
            expect(page.get_by_test_id("robot /robot100")).to_contain_text("Stopped")
            expect(page.get_by_test_id("stop-banner")).to_be_visible()
            gateway.http.delete("/stop").raise_for_status()
            expect(page.get_by_test_id("stop-banner")).to_be_hidden()
            expect(page.get_by_test_id("robot /robot100")).not_to_contain_text("Stopped")

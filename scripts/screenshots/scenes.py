"""The robots in the pictures, and what they have done before."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from playwright.sync_api import Page, expect
from scripts.screenshots.camera import Camera
from sensor_msgs.msg import BatteryState
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.processes import BIN, ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

START_S, DRIVE_S = 60.0, 90.0
CHARGES = {"/robot1": 0.4, "/robot2": 0.6, "/robot3": 0.12}
NEAR = ("-p", "start_x:=-1.7", "-p", "start_y:=0.75", "-p", "start_theta:=0.1")
SERVER = ("-p", "controller:=dock_pose")
FLEET_PAGES = {"fleet-robot": "/ui/robot?robot=/robot1", "map": "/ui/map"}
FLEET = [("-r", f"__ns:={name}", *NEAR, "-p", f"battery_start:={charge}") for name, charge in CHARGES.items()]


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


@contextmanager
def fleet_of_up(domain: int) -> Iterator[RunningGateway]:
    """A gateway and the robots of `dock-gateway up --robots 3`."""
    fleet = ("-m", "docking.nodes.simulated_fleet", "3")
    with ForkedProcess(*fleet, env=ros_environment(domain)), running_gateway(domain, namespace="/robot1") as gateway:
        wait_until(lambda: len(robots_of(gateway)) == len(CHARGES), "every robot", START_S)
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


def set_up(gateway: RunningGateway) -> None:
    """Store a rule of automatic docking, which only records what it would do, and a webhook that nothing answers."""
    everyone = {"all": True}
    rule = {"name": "Low battery", "mode": "dry_run", "robots": everyone, "battery": {"below": 0.3, "idle_s": 60}}
    webhook = {"name": "Control room", "url": "http://127.0.0.1:9/alerts", "robots": everyone}
    gateway.http.put("/automation/rules/low-battery", json=rule).raise_for_status()
    gateway.http.put("/webhooks/control-room", json=webhook).raise_for_status()
    gateway.http.post("/webhooks/control-room/test").raise_for_status()


def live_a_day(gateway: RunningGateway, domain: int, page: Page, seconds: float) -> str:
    """Let goals end as goals do, and name one that succeeded."""
    set_up(gateway)
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


def still_pages(goal_id: str) -> dict[str, str]:
    """The pages of one robot that need nothing to happen: their paths by name."""
    return {
        "dock-action": "/ui/actions/connect_to_charging_dock",
        "developer": "/ui/robot?tab=developer",
        "actions": "/ui/actions",
        "goals": "/ui/goals",
        "statistics": "/ui/statistics",
        "automation": "/ui/automation",
        "notifications": "/ui/notifications",
        "goal": f"/ui/goals/{goal_id}",
        "graph-nodes": "/ui/graph?show=nodes&gateway=true",
        "graph-list": "/ui/graph?view=list",
        "no-page": "/ui/nothing",
    }


def one_robot(camera: Camera, gateway: RunningGateway, domain: int, seconds: float) -> None:
    """Take the pages as they are with one robot."""
    docked = live_a_day(gateway, domain, camera.open("/"), seconds)
    camera.open("/")
    goal = dock_from_afar(gateway)
    expect(camera.page.get_by_text("Driving to the staging pose").first).to_be_visible(timeout=START_S * 1000)
    camera.take("overview")
    wait_for(gateway, goal, "succeeded")
    camera.open("/ui/actions/fibonacci").get_by_role("button", name="Send goal").click()
    expect(camera.page.get_by_role("list", name="partial_sequence").get_by_role("listitem")).to_have_count(6)
    camera.take("action")
    for name, path in still_pages(docked).items():
        camera.open(path)
        camera.take(name)
    camera.open("/ui/graph?selected=topic:/battery_status&echo=true")
    expect(camera.page.get_by_role("region", name="Live messages")).to_contain_text(" Hz")
    camera.take("graph")
    camera.page.get_by_role("button", name="Keyboard and name").click()
    camera.take("keyboard")


def several_robots(camera: Camera, gateway: RunningGateway) -> None:
    """Take the overview: one robot docks, one is docked, one has a low battery."""
    wait_for(gateway, send(gateway, "dock", "?robot=/robot2"), "succeeded")
    wait_until(lambda: gateway.http.get("/alerts").json()["alerts"], "an alert", START_S)
    camera.open("/")
    dock_from_afar(gateway, "?robot=/robot1")
    expect(camera.page.get_by_role("table")).to_contain_text("Dock: Staging")
    camera.take("fleet")
    for name, path in FLEET_PAGES.items():
        camera.open(path)
        camera.take(name)

"""The docking action server for tests: in the test process, or as the process that users start."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.context import Context
from sensor_msgs.msg import BatteryState

from action_tutorials_interfaces.action import ConnectToChargingDock, DisconnectFromChargingDock
from docking.core.battery import Battery
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import watch_obstacles
from docking.goal.plan import Plan
from docking.nodes.dock_server import DockAction, docking_objective
from docking.nodes.undock_server import UndockAction
from docking.parameters import DockSettings
from docking.ros.active_goal import ActiveGoal
from docking.ros.battery_subscriber import BatteryStateSubscriber
from docking.ros.node import ActionNode
from docking.ros.process import Spinner
from tests.support.observer import GoalOfTest, Observer, ros_nodes
from tests.support.waiting import PATIENCE, wait_until

ACTION = "connect_to_charging_dock"
SERVER = "/connect_to_charging_dock_action_server"
UNDOCK_ACTION = "disconnect_from_charging_dock"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


def battery_state(status: int) -> BatteryState:
    """The tutorial's battery: 24 % of a 9 V battery."""
    return BatteryState(voltage=2.16, percentage=0.24, power_supply_status=status)


LOW = battery_state(3)
CHARGING = battery_state(1)


def dock_goal(status: int = 1) -> ConnectToChargingDock.Goal:
    """The tutorial's goal."""
    return ConnectToChargingDock.Goal(desired_battery_state=battery_state(status))


def send_undock_goal(observer: Observer, status: int = 0, action: str = UNDOCK_ACTION) -> GoalOfTest:
    """Send a goal to undock and wait until it is accepted or rejected."""
    goal = DisconnectFromChargingDock.Goal(desired_battery_state=battery_state(status))
    return observer.send_goal(DisconnectFromChargingDock, action, goal)


def send_dock_goal(observer: Observer, status: int = 1, action: str = ACTION, *, dock: str = "") -> GoalOfTest:
    """Send the tutorial's goal, to a dock by name, and wait until it is accepted or rejected."""
    goal = dock_goal(status)
    goal.desired_battery_state.location = dock
    return observer.send_goal(ConnectToChargingDock, action, goal)


class PlannedDockAction(DockAction):
    """Docking by a plan of the test's."""

    def __init__(self, make_plan: Callable[[DockSettings], Plan]) -> None:
        self._make_plan = make_plan

    def make_goal(self, settings: DockSettings, memory: DockMemory, started_at: float) -> Goal:
        obstacles = watch_obstacles(settings, backward=settings.dock.backward)
        return Goal(self._make_plan(settings), docking_objective(settings, memory), started_at, obstacles)


def _dock_action(make_plan: Callable[[DockSettings], Plan] | None) -> DockAction:
    return DockAction() if make_plan is None else PlannedDockAction(make_plan)


# Simulated seconds in each second, where a test is not about the motion itself. To the servers, which live in real
# time, the robot is so many times faster than it is told to be; so they must not look whether it moves as it is told.
FAST = "real_time_factor:=3.0"
UNMEASURED = "blocked_after:=60.0"

# A busy machine is no broken odometry.
PATIENT = "odometry_timeout:=10.0"


@contextmanager
def docking_servers(
    domain: int,
    *parameters: str,
    make_plan: Callable[[DockSettings], Plan] | None = None,
    file: Path | None = None,
) -> Iterator[tuple[ActionNode[Any], ActionNode[Any]]]:
    """The docking and the undocking server in the test process, with the battery subscriber.

    Args:
        domain: The ROS domain.
        parameters: As on the command line: `name:=value`.
        file: More parameters, which count less.
        make_plan: Makes plans in place of those that the parameters ask for.
    """
    arguments = [text for parameter in (PATIENT, *parameters) for text in ("-p", parameter)]
    if file is not None:
        arguments = ["--params-file", str(file), *arguments]
    with ros_nodes(domain, *arguments) as context:
        battery, active_goal = Battery(), ActiveGoal()
        dock = ActionNode(_dock_action(make_plan), battery, active_goal=active_goal, context=context)
        undock = ActionNode(UndockAction(), battery, active_goal=active_goal, context=context)
        with _spun(context, battery, dock, undock):
            yield dock, undock


@contextmanager
def dock_server(
    domain: int,
    *parameters: str,
    make_plan: Callable[[DockSettings], Plan] | None = None,
) -> Iterator[ActionNode[Any]]:
    """The tutorial's two nodes in the test process; see `docking_servers`."""
    arguments = [text for parameter in parameters for text in ("-p", parameter)]
    with ros_nodes(domain, *arguments) as context:
        battery = Battery()
        server = ActionNode(_dock_action(make_plan), battery, context=context)
        with _spun(context, battery, server):
            yield server


@contextmanager
def _spun(context: Context, battery: Battery, *servers: ActionNode[Any]) -> Iterator[None]:
    with Spinner(context, [*servers, BatteryStateSubscriber(battery, context=context)]) as spinner:
        yield
        for server in servers:
            spinner.call(server.close).result(PATIENCE)
    assert spinner.failure is None


@dataclass
class Wheels:
    """What came on cmd_vel."""

    messages: list[Twist]

    @property
    def moving(self) -> bool:
        """Whether the last message was a motion."""
        return bool(self.messages) and self.messages[-1] != Twist()

    @property
    def zeros(self) -> int:
        """How many messages at the end were zero."""
        return sum(1 for _ in takewhile(lambda message: message == Twist(), reversed(self.messages)))

    @property
    def standing(self) -> bool:
        """Whether the last message was zero."""
        return bool(self.messages) and self.messages[-1] == Twist()


def watch_wheels(observer: Observer, topic: str = "cmd_vel") -> Wheels:
    """Subscribe to cmd_vel, and wait for its publisher."""
    recording = observer.record(Twist, topic)
    recording.wait_for_publisher()
    return Wheels(recording.messages)


class Reports:
    """What came on /diagnostics."""

    def __init__(self, observer: Observer) -> None:
        self._recording = observer.record(DiagnosticArray, "/diagnostics")
        self._recording.wait_for_publisher()

    @property
    def all(self) -> list[dict[str, Any]]:
        """The key values of each report, and its level, name and message."""
        return [_read(status) for message in self._recording.messages for status in message.status]

    def wait_for(self, timeout: float = PATIENCE, **expected: str | int) -> dict[str, Any]:
        """Wait for a report with these values."""

        def found() -> dict[str, Any] | None:
            return next((report for report in self.all if expected.items() <= report.items()), None)

        report = wait_until(found, f"a report with {expected}", timeout)
        assert report is not None
        return report


def _read(status: DiagnosticStatus) -> dict[str, Any]:
    values = {pair.key: pair.value for pair in status.values}
    return {"level": status.level[0], "name": status.name, "message": status.message, **values}

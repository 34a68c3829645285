"""The docking action server for tests: in the test process, or as the process that users start."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from sensor_msgs.msg import BatteryState

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.battery import Battery
from docking.battery_node import BatteryStateSubscriber
from docking.controllers.plan import Plan
from docking.dock_server_node import DockServer
from docking.parameters import DockSettings
from docking.plans import make_plan
from docking.ros.process import Spinner
from tests.support.observer import GoalOfTest, Observer, ros_nodes

ACTION = "connect_to_charging_dock"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


def battery_state(status: int) -> BatteryState:
    """The tutorial's battery: 24 % of a 9 V battery."""
    return BatteryState(voltage=2.16, percentage=0.24, power_supply_status=status)


LOW = battery_state(3)
CHARGING = battery_state(1)


def dock_goal(status: int = 1) -> ConnectToChargingDock.Goal:
    """The tutorial's goal."""
    return ConnectToChargingDock.Goal(desired_battery_state=battery_state(status))


def send_dock_goal(observer: Observer, status: int = 1, action: str = ACTION) -> GoalOfTest:
    """Send the tutorial's goal and wait until it is accepted or rejected."""
    return observer.send_goal(ConnectToChargingDock, action, dock_goal(status))


@contextmanager
def dock_server(
    domain: int,
    *parameters: str,
    make_plan: Callable[[DockSettings], Plan] = make_plan,
) -> Iterator[DockServer]:
    """The server's two nodes in the test process.

    Args:
        domain: The ROS domain.
        parameters: As on the command line: `name:=value`.
        make_plan: In place of what the parameters ask for.
    """
    arguments = [text for parameter in parameters for text in ("-p", parameter)]
    with ros_nodes(domain, *arguments) as context:
        battery = Battery()
        server = DockServer(battery, make_plan=make_plan, context=context)
        subscriber = BatteryStateSubscriber(battery, context=context)
        with Spinner(context, [server, subscriber]) as spinner:
            yield server
            spinner.call(server.close).result(5.0)
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
        """The key values of each report, and its level and name."""
        return [_read(status) for message in self._recording.messages for status in message.status]

    def wait_for(self, **expected: str) -> dict[str, Any]:
        """Wait for a report with these values."""

        def matches(message: DiagnosticArray) -> bool:
            return expected.items() <= _read(message.status[0]).items()

        return _read(self._recording.wait_for(matches).status[0])


def _read(status: DiagnosticStatus) -> dict[str, Any]:
    values = {pair.key: pair.value for pair in status.values}
    return {"level": status.level[0], "name": status.name, **values}

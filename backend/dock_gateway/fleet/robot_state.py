"""The state of one robot, combined from all sources. Plain data."""

from dataclasses import dataclass
from typing import Any

from dock_gateway.core.battery import PowerSupply
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.goals.hints import Join
from dock_gateway.goals.liveness import ServerState
from dock_gateway.robots.battery import BatteryPublisher, LatestBattery
from dock_gateway.robots.labels import RobotLabel

CHARGES = frozenset({PowerSupply.CHARGING, PowerSupply.FULL})
DRAINS = frozenset({PowerSupply.DISCHARGING, PowerSupply.NOT_CHARGING})
# A current in A below which it tells nothing: drivers that measure none send 0, and those that do have an offset.
NO_CURRENT = 0.05


@dataclass(frozen=True)
class RobotState:
    """A snapshot of one robot.

    Attributes:
        name: Its namespace.
        label: Its display name and groups.
        default: Whether it is the robot that the gateway is configured for.
        battery: Its battery.
        battery_topic: The topic of its battery.
        publisher: The publisher that stands in for its battery driver.
        stop: Whether a stop holds for it, as `GET /stop` shows it.
        simulator: The report of its simulator, as `GET /simulator` shows it, or None without a simulator.
        dock: The server of its docking action, or None if it has no such action.
        undock: The server of its undocking action, or None.
        goals: The running goals on its actions, newest first.
        lost: The lost goals on its actions after which nothing has been learned of it, newest first.
        last_goal: The last docking or undocking goal that ended.
        left_docked: Whether the last of them that succeeded left it docked; None if none succeeded.
    """

    name: str
    label: RobotLabel
    default: bool
    battery: LatestBattery
    battery_topic: str
    publisher: BatteryPublisher
    stop: dict[str, Any]
    simulator: dict[str, Any] | None
    dock: ServerState | None
    undock: ServerState | None
    goals: list[Goal]
    lost: list[Goal]
    last_goal: Goal | None
    left_docked: bool | None

    @property
    def docked(self) -> bool | None:
        """Whether it is docked; None if unknown.

        The sources by priority: the simulator, a battery that is being charged, the goals.
        """
        said = self.simulator and self.simulator["docked"]
        if said is not None:
            return bool(said)
        return True if self.battery.reading.power_supply in CHARGES else self.left_docked

    @property
    def on_dock(self) -> bool:
        """Whether it is docked or, according to a simulator, at least touches its dock."""
        return bool(self.docked or (self.simulator and self.simulator["contact"]))

    @property
    def charging(self) -> bool | None:
        """Whether its battery is being charged or full; None if unknown.

        If the status is UNKNOWN, as it always is on a Create 3, the current of a docked robot tells it. Elsewhere it
        does not: a robot that brakes also charges.
        """
        reading = self.battery.reading
        if reading.power_supply in CHARGES:
            return True
        if reading.power_supply in DRAINS:
            return False
        if not self.on_dock or reading.current is None or abs(reading.current) < NO_CURRENT:
            return None
        return reading.current > 0

    def docking(self, *servers: ServerState | None) -> bool:
        """Return whether a goal runs on one of these actions, `dock` or `undock`."""
        names = {server.action_name for server in servers if server is not None}
        return any(goal.action_name in names for goal in self.goals)

    def document(self, grant: Grant = UNLIMITED, join: Join | None = None) -> dict[str, Any]:
        """Return the state as `GET /robots` shows it, ready for `orjson`, without ages, which change all the time.

        Args:
            grant: Only goals that it covers are shown.
            join: The settings that would give it a docking server.
        """
        publisher = self.publisher.document()
        last = self.last_goal
        return {
            "name": self.name,
            "display_name": self.label.display_name,
            "groups": self.label.groups,
            "default": self.default,
            "docked": self.docked,
            "charging": self.charging,
            "simulated": self.simulator is not None,
            "battery": self.battery.document(),
            "battery_topic": self.battery_topic,
            "battery_publisher": {"active": publisher["active"], "rate_hz": publisher["rate_hz"]},
            "stop": self.stop,
            "dock": self.dock,
            "undock": self.undock,
            "join": None if join is None else {"detail": join.detail, "settings": join.settings},
            "goals": [goal.state() for goal in self.goals if grant.covers_action(goal.action_name)],
            "last_goal": last.state() if last is not None and grant.covers_action(last.action_name) else None,
        }

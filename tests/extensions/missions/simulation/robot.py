"""A simulated robot: its battery, its action servers, and the docks that robots share."""

import random
from collections.abc import Callable
from typing import Any

from dock_gateway.core.battery import PowerSupply
from dock_gateway.core.goal import GoalStatus
from tests.dock_gateway.simulation.chance import Chance
from tests.extensions.missions.simulation.server import CarriedOut, Server
from tests.extensions.missions.simulation.troubles import HOUR

# The actions of a robot: the kind, its name in the robot's namespace, and its type.
ACTIONS = (
    ("dock", "connect_to_charging_dock", "action_tutorials_interfaces/action/ConnectToChargingDock"),
    ("undock", "disconnect_from_charging_dock", "action_tutorials_interfaces/action/DisconnectFromChargingDock"),
    ("work", "work", "action_tutorials_interfaces/action/Fibonacci"),
    ("navigate", "navigate_to_pose", "nav2_msgs/action/NavigateToPose"),
)
# The charge that is lost an hour while a goal runs and while the robot stands, and gained at a dock.
DRIVES, STANDS, CHARGES = -0.3, -0.03, 0.6


class Docks:
    """The docks: where robots wait for them, which are blocked, and who stands at them.

    Args:
        draw: Decides where robots wait.
        number: How many docks there are.
        waiting_places: Share of those that have places where robots wait.
    """

    def __init__(self, draw: random.Random, number: int, waiting_places: float) -> None:
        self.names = [f"dock{index}" for index in range(number)]
        self.places: dict[str, list[dict[str, Any]]] = {
            name: [{"x": float(dock), "y": float(place)} for place in range(draw.randint(1, 2))]
            if draw.random() < waiting_places
            else []
            for dock, name in enumerate(self.names)
        }
        self.blocked = set[str]()
        self.robots: dict[str, str] = {}


class Robot:
    """A robot.

    Args:
        chance: The clock and the dice.
        name: Its namespace.
        docks: The docks.
        accepted: Called with the robot, the server and each goal that it accepts.
        answers_lost: How likely it is that an answer is lost.
        battery_speed: How many times faster than in a real robot its battery is charged and discharged.
        navigating: Whether it has nav2.

    Attributes:
        on: Whether it is switched on.
        in_reach: Whether messages reach it.
        docked_at, changed_at: When it last arrived at a dock, and got another battery.
        answers_lost, rejects, refuses, fails, hangs: How likely it is that an answer is lost, a goal is rejected, a
            request to cancel is refused, a goal fails, or never ends by itself.
    """

    def __init__(
        self,
        chance: Chance,
        name: str,
        docks: Docks,
        accepted: Callable[["Robot", Server, CarriedOut], None],
        *,
        answers_lost: float,
        battery_speed: float,
        navigating: bool,
    ) -> None:
        self.chance = chance
        self.name = name
        self.docks = docks
        self.on = True
        self.in_reach = True
        self.docked_at = self.changed_at = 0.0
        self.answers_lost = answers_lost
        self.rejects, self.refuses, self.fails, self.hangs = 0.03, 0.03, 0.12, 0.05
        self._accepted = accepted
        self._charge = chance.random.uniform(0.2, 0.9)
        self._battery_speed = battery_speed
        self._since = chance.loop.time()
        self._rate = STANDS * battery_speed
        self.servers = {
            kind: Server(self, kind, f"{name}/{action}", of)
            for kind, action, of in ACTIONS
            if navigating or kind != "navigate"
        }

    def mend(self) -> None:
        """Let nothing go wrong from now on."""
        self.on = self.in_reach = True
        self.answers_lost = self.rejects = self.refuses = self.fails = self.hangs = 0.0
        for server in self.servers.values():
            server.awake.set()
            server.up = True
            for goal in [*server.goals.values()]:
                if goal.runs and goal.status is not GoalStatus.CANCELING and goal.hangs:
                    server.unhang(goal)
            server.tell()

    def switch_off(self) -> None:
        """End all that runs on the robot."""
        self.on = False
        for server in self.servers.values():
            server.drop()
        self.drive()

    def switch_on(self) -> None:
        """Start again, with servers that know nothing of before, if it is off."""
        if not self.on:
            self.on = True
            self.drive()
            for server in self.servers.values():
                server.up = True
                server.tell()

    def reach(self) -> None:
        """Come back into reach."""
        self.in_reach = True
        for server in self.servers.values():
            server.tell()

    @property
    def there(self) -> bool:
        """Whether its messages arrive."""
        return self.on and self.in_reach

    # ------------------------------------------------------------------ the battery

    @property
    def dock(self) -> str | None:
        """The dock at which it stands."""
        return next((dock for dock, robot in self.docks.robots.items() if robot == self.name), None)

    @property
    def charge(self) -> float:
        """The charge of its battery, 0 to 1."""
        hours = (self.chance.loop.time() - self._since) / HOUR
        return min(1.0, max(0.0, self._charge + self._rate * hours))

    @property
    def supply(self) -> PowerSupply:
        """What its battery says of its charger."""
        if self._rate <= 0:
            return PowerSupply.DISCHARGING
        return PowerSupply.FULL if self.charge >= 1.0 else PowerSupply.CHARGING

    def drive(self) -> None:
        """Go on with another current."""
        self._charge, self._since = self.charge, self.chance.loop.time()
        runs = any(goal.runs for server in self.servers.values() for goal in server.goals.values())
        rate = CHARGES if self.dock is not None and self.on else DRIVES if runs else STANDS
        self._rate = rate * self._battery_speed

    def change_battery(self) -> None:
        """Somebody gives it another battery."""
        self.drive()
        self._charge, self.changed_at = 0.9, self._since

    # ------------------------------------------------------------------ goals

    def running(self) -> list[CarriedOut]:
        """Return the goals that it carries out."""
        return [goal for server in self.servers.values() for goal in server.goals.values() if goal.runs]

    def on_accept(self, server: Server, goal: CarriedOut) -> None:
        """A server has accepted a goal."""
        self._accepted(self, server, goal)
        if self.dock is not None and (server.kind != "dock" or self.dock_of(goal.message) != self.dock):
            del self.docks.robots[self.dock]
        self.drive()

    def plan(self, server: Server, goal: CarriedOut) -> tuple[float | None, bool]:
        """Return how long a goal takes, None: until it is canceled, and whether it succeeds then."""
        draw = self.chance.random
        if draw.random() < self.hangs:
            goal.hangs = True
            return None, False
        longest = 300.0 if server.kind == "work" else 60.0
        return draw.uniform(2.0, longest), draw.random() >= self.fails

    def finish(self, server: Server, goal: CarriedOut) -> GoalStatus:
        """Return how a goal ends that would succeed."""
        if server.kind == "dock":
            dock = self.dock_of(goal.message)
            if dock in self.docks.blocked or self.docks.robots.get(dock, self.name) != self.name:
                return GoalStatus.ABORTED
            self.docks.robots[dock] = self.name
            self.docked_at = self.chance.loop.time()
        return GoalStatus.SUCCEEDED

    def dock_of(self, message: dict[str, Any]) -> str:
        """Return the dock that a goal names."""
        desired = message.get("desired_battery_state") or {}
        return str(desired.get("location") or message.get("dock_id") or self.docks.names[0])

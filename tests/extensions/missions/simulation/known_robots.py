"""The robots as a gateway knows them, in place of `dock_gateway.robots.registry`."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from dock_gateway.core.battery import BatteryReading
from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.filters import GoalFilter, is_under
from dock_gateway.core.goal import Goal
from dock_gateway.core.listeners import Hooks, Listeners
from dock_gateway.core.namespace import ALL_ROBOTS
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.storage import History
from tests.extensions.missions.simulation.robot import Robot
from tests.support.stopping import FakeWheels


class KnownRobots:
    """The robots as a gateway knows them."""

    own_robot = True

    def __init__(self, robots: dict[str, Robot], bridge: Any) -> None:
        self._robots = {name: _robot(robot) for name, robot in robots.items()}
        self.default_namespace = next(iter(robots))
        self.at_work = Hooks[Callable[[str], bool]]()
        self.topics = SimpleNamespace(bridge=bridge)
        # What drives by its velocity topic alone is not simulated.
        self.velocities = SimpleNamespace(listen=lambda *_: SimpleNamespace(complete=True, close=lambda: None))
        self.on_low_battery = Listeners[[str, float]]("a robot at work has to charge")

    def namespaces(self) -> list[str]:
        return sorted(self._robots)

    def __contains__(self, name: str) -> bool:
        return name in self._robots

    def get(self, name: str | None = None) -> Any:
        found = self._robots.get(name or self.default_namespace)
        if found is None:
            raise NotFound(f"there is no robot {name}", code="robot_not_found")
        return found

    def find(self, name: str | None = None) -> str:
        return str(self.get(name).namespace)

    def owner(self, action_name: str) -> Any:
        return next((robot for name, robot in self._robots.items() if is_under(action_name, name)), None)

    def place(self, name: str | None = None) -> str:
        return ALL_ROBOTS if name is None else self.find(name)

    def under(self, namespace: str) -> list[Any]:
        return [robot for name, robot in self._robots.items() if is_under(name, namespace)]

    def is_at_work(self, namespace: str) -> bool:
        return any(has_work(namespace) for has_work in self.at_work)


class Battery:
    """The battery of a robot, as a gateway has it."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot

    @property
    def age(self) -> float | None:
        return 0.5

    @property
    def stale_since(self) -> float | None:
        return None if self._robot.there else 1.0

    @property
    def reading(self) -> Any:
        return BatteryReading(percentage=self._robot.charge, power_supply=self._robot.supply)


def _robot(robot: Robot) -> Any:
    return SimpleNamespace(namespace=robot.name, wheels=FakeWheels(), battery=Battery(robot))


class KnownFleet:
    """The state of each robot as a gateway knows it, in place of `dock_gateway.fleet.fleet`.

    Args:
        robots: The robots.
        known: The same, as the gateway knows them.
        actions: Their actions.
        labels: Their labels.
        interlock: The latched stops.
    """

    def __init__(
        self,
        robots: dict[str, Robot],
        known: KnownRobots,
        actions: ActionRegistry,
        labels: RobotLabels,
        interlock: Interlock,
    ) -> None:
        self._robots = robots
        self._known = known
        self._actions = actions
        self._labels = labels
        self._interlock = interlock
        self._last: dict[str, Goal] = {}
        self._docked: dict[str, bool | None] = {}  # as it was last heard

    async def open(self, history: History) -> None:
        """Read which docking or undocking goal of each robot was the last."""
        self._actions.on_end.append(self._take)
        for name in self._robots:
            goals = await history.page(GoalFilter(namespace=name, verb=None), limit=50)
            for goal in reversed(goals):
                self._take(goal)

    def _take(self, goal: Goal) -> None:
        if goal.verb is not None and goal.status.final:
            robot = self._known.owner(goal.action_name)
            self._last[robot.namespace] = goal

    def states(self) -> list[Any]:
        """Return the state of each robot."""
        return [self._state(robot) for robot in self._robots.values()]

    def state(self, name: str) -> Any:
        """Return the state of a robot."""
        return self._state(self._robots[name])

    def _state(self, robot: Robot) -> Any:
        name = robot.name
        if robot.there:
            self._docked[name] = robot.dock is not None
        return SimpleNamespace(
            name=name,
            battery=self._known.get(name).battery,
            docked=self._docked.get(name),
            on_dock=bool(self._docked.get(name)),
            last_goal=self._last.get(name),
            dock=SimpleNamespace(
                action_name=robot.servers["dock"].name, available=robot.there, answering=robot.there, duplicate=False
            ),
            stop={"latched": self._interlock.holds(name), "by": None, "stopped_at": utc_now()},
            default=False,
            simulator=None,
            goals=[goal for goal in self._actions.running() if is_under(goal.action_name, name)],
            lost=[] if robot.there else [goal for goal in self._actions.lost() if is_under(goal.action_name, name)],
            label=self._labels.get(name),
        )


class KnownDocks:
    """The docks that each robot's docking server lists, in place of `dock_gateway.goals.docks`.

    Args:
        names: Their names.
    """

    def __init__(self, names: list[str]) -> None:
        self._names = names

    async def require(self, *_: Any) -> None:
        """Have every dock."""

    async def document(self, *_: Any) -> dict[str, Any]:
        """Return the docks."""
        return {"docks": [{"dock_id": name, "frame": None, "pose": None} for name in self._names]}

"""The facts that rules go by, read from the state of the robots."""

import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from typing import Any

from dock_gateway.core.battery import PowerSupply
from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.automation.activity import Activity
from dock_gateway.extensions.automation.policy import RobotFacts
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.robot_state import CHARGES, RobotState

# Seconds for which the battery of a docked robot must be discharging until the robot counts as off its charger.
OFF_CHARGER = 30.0


class FactReader:
    """Reads the facts about the robots.

    Args:
        fleet: The state of the robots.
        activity: Since when robots stand still.
        shared: Returns the robots that may be other names of one robot.
        at_work: Returns whether a robot has work that must not be interrupted.
        held: Returns whether a robot was stopped, and no person has continued its automatic docking since.
    """

    def __init__(
        self,
        fleet: Fleet,
        activity: Activity,
        shared: Callable[[], Collection[str]] = frozenset,
        at_work: Callable[[str], bool] = lambda _: False,
        held: Callable[[str], bool] = lambda _: False,
    ) -> None:
        self._fleet = fleet
        self._activity = activity
        self._shared = shared
        self._at_work = at_work
        self._held = held
        self._off_since: dict[str, float] = {}  # docked robots whose batteries discharge

    def read(self) -> dict[str, RobotFacts]:
        """Return the facts about each robot now, by its namespace."""
        states = self._fleet.states()
        servers = Counter(state.dock.action_name for state in states if state.dock is not None and _is_there(state))
        return {state.name: self._facts(state, servers) for state in states}

    def _facts(self, state: RobotState, servers: Mapping[str, int]) -> RobotFacts:
        name, reading, server = state.name, state.battery.reading, state.dock
        heard = state.battery.age is not None
        fresh = heard and state.battery.stale_since is None
        if state.goals or state.lost:
            self._activity.active(name)
        last = state.last_goal
        failed = last is not None and last.status is not GoalStatus.SUCCEEDED
        return RobotFacts(
            name=name,
            groups=tuple(state.label.groups),
            heard=heard or (server is not None and server.available),
            fresh=fresh,
            battery=reading.percentage,
            docked=(state.on_dock and not self._left_charger(state, fresh))
            or (fresh and reading.power_supply in CHARGES),
            reachable=server is not None and server.available and server.answering and not server.duplicate,
            shares_dock=server is not None and (servers.get(server.action_name, 0) > 1 or name in self._shared()),
            goal_running=bool(state.goals),
            goal_lost=bool(state.lost),
            at_work=self._at_work(name),
            stopped=_stopped(state.stop),
            held=self._held(name),
            still_since=self._activity.still_since(name),
            person_at=self._activity.person_at(name),
            failed_at=last.finished_at if last is not None and failed else None,
        )

    def _left_charger(self, state: RobotState, fresh: bool) -> bool:
        """Return whether a robot that a goal has left docked has been off its charger for a while: it may slide off.

        A battery that takes no current is NOT_CHARGING on its dock; one that is DISCHARGING has no charger, or a dead
        one.
        """
        touches = state.simulator is not None and state.simulator["contact"]
        if touches or not fresh or state.battery.reading.power_supply != PowerSupply.DISCHARGING:
            self._off_since.pop(state.name, None)
            return False
        now = time.monotonic()
        return now - self._off_since.setdefault(state.name, now) >= OFF_CHARGER


def _is_there(state: RobotState) -> bool:
    """Return whether a robot is there: the one of the settings is always known."""
    return not state.default or state.battery.age is not None


def _stopped(stop: Mapping[str, Any]) -> str | None:
    if not stop["latched"]:
        return None
    by = f" by {stop['by']}" if stop["by"] else ""
    return f"stopped{by} at {stop['stopped_at']:%H:%M:%S} UTC"

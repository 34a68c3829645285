"""The robots that may take missions of their groups, read from the state of the fleet."""

from collections.abc import Callable, Mapping
from datetime import datetime

from dock_gateway.extensions.missions.turns import RobotFacts
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.robots.robots import RobotLabels


class Candidates:
    """Reads which robots are free.

    Args:
        fleet: The state of the robots.
        labels: Their groups.
        low_battery: Charge (0 to 1) below which a battery is low.
        last_stop: Returns when a robot was last stopped.
    """

    def __init__(
        self, fleet: Fleet, labels: RobotLabels, low_battery: float, last_stop: Callable[[str], datetime | None]
    ) -> None:
        self._fleet = fleet
        self._labels = labels
        self._low_battery = low_battery
        self._last_stop = last_stop

    def read(self) -> Mapping[str, RobotFacts]:
        """Return what is known of each robot that is there, or has a label, by its namespace."""
        found = {robot: RobotFacts(self._labels.get(robot).groups) for robot in self._labels.robots()}
        return found | {state.name: self._facts(state) for state in self._fleet.states()}

    def _facts(self, state: RobotState) -> RobotFacts:
        battery, charge = state.battery, state.battery.reading.percentage
        heard = battery.age is not None and battery.stale_since is None
        charged = charge is not None and charge >= self._low_battery
        idle = not (state.stop["latched"] or state.goals or state.lost)
        return RobotFacts(
            groups=tuple(state.label.groups),
            free=heard and charged and idle,
            charge=charge or 0.0,
            stopped_at=self._last_stop(state.name),
        )

"""The present state of a gateway for a reader: goals, and what else was asked for of one robot and of all."""

from collections.abc import Callable
from typing import Any

from dock_gateway.core.event import Event, fleet_event, stop_event, system_event, utc_now
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.core.narrowing import narrow_alerts, narrow_approvals, narrow_robots
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.simulator import Simulators
from dock_gateway.stop.stopper import Stopper
from dock_gateway.streams.current_state import snapshot_of

NARROW = {"robots": narrow_robots, "alerts": narrow_alerts, "approvals": narrow_approvals}


class GatewayState:
    """The present state of a gateway.

    Args:
        parts: The parts of the gateway.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        # By the type of the events that change it.
        self._states: dict[str, Callable[[EventFilter], Any]] = {
            "battery": lambda wanted: parts[RobotRegistry].get(wanted.robot).battery.document(),
            "stop": lambda wanted: parts[Stopper].state(wanted.robot),
            "battery_publisher": lambda wanted: parts[RobotRegistry].get(wanted.robot).publisher.document(),
            "docking": lambda wanted: parts[ActionRegistry].servers_of(wanted.robot)._asdict(),
            "simulator": lambda wanted: parts[Simulators].document(wanted.robot),
            "robots": lambda wanted: parts[Fleet].documents(grant=wanted.grant or UNLIMITED),
            "alerts": lambda wanted: parts[AlertBoard].documents(wanted.grant or UNLIMITED),
            "approvals": lambda wanted: parts[Approvals].documents(wanted.grant or UNLIMITED),
        }

    def _states_of(self, event_filter: EventFilter) -> dict[str, Any]:
        asked = event_filter.topics
        if "action_server" in asked:
            asked |= {"docking"}
        return {kind: state(event_filter) for kind, state in self._states.items() if kind in asked}

    async def snapshot(self, event_filter: EventFilter, position: str) -> Event:
        """Return running and recent goals, and what else the reader asked for."""
        goals = await self._parts[Goals].recent(event_filter)
        return snapshot_of(goals, self._states_of(event_filter), event_filter, position)

    def events(self, event_filter: EventFilter) -> list[Event]:
        """Return the current state as events, for a reader who resumes: battery states have an id and are replayed."""
        robot, now = event_filter.robot, utc_now()
        events = []
        for kind, state in self._states_of(event_filter).items():
            if kind in NARROW:
                events.append(fleet_event(kind, now, NARROW[kind], **_whole(kind, state)))
            elif kind == "stop":
                events.append(stop_event(state, None, robot=robot))
            elif kind != "battery" and state is not None:
                events.append(system_event(kind, state, now, robot=robot))
        if "action_server" in event_filter.topics:
            servers = self._parts[ActionRegistry].servers_of(robot)
            events += [system_event("action_server", state, now, action_name=state.action_name) for state in servers]
        return [event for event in events if event_filter.covers(event)]


def _whole(kind: str, state: Any) -> dict[str, Any]:
    """Return the fields of an event with all robots, alerts or approvals."""
    return {kind: state, "gone": []} if kind == "robots" else {kind: state}

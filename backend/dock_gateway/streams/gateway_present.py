"""The snapshot of a gateway for a reader: goals, the state of one robot, and all robots if asked for."""

from dock_gateway.core.event import Event, fleet_event, notice, system_event, utc_now
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


class GatewayPresent:
    """The present state of a gateway.

    Args:
        parts: The parts of the gateway.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts

    async def snapshot(self, event_filter: EventFilter, position: str) -> Event:
        """Return running and recent goals; the robot's battery, stop and servers; robots and alerts if asked for."""
        parts = self._parts
        goals = await parts[Goals].recent(event_filter)
        robot = parts[RobotRegistry].get(event_filter.robot)
        dock, undock = parts[ActionRegistry].servers_of(event_filter.robot)
        fleet = {}
        if "robots" in event_filter.topics:
            grant = event_filter.grant or UNLIMITED
            fleet = {
                "robots": parts[Fleet].documents(grant=grant),
                "alerts": parts[AlertBoard].documents(grant),
                "approvals": parts[Approvals].documents(grant),
            }
        return notice(
            "snapshot",
            utc_now(),
            position=position,
            ends_goal=event_filter.goal_id is not None and all(goal.status.terminal for goal in goals),
            goals=[goal.document() for goal in goals],
            battery=robot.battery.document(),
            battery_publisher=robot.publisher.document(),
            stop=parts[Stopper].state(robot.namespace),
            action_server=dock,
            undock_server=undock,
            **fleet,
        )

    def events(self, event_filter: EventFilter) -> list[Event]:
        """Return the current state as events, for events that have no id and so are not replayed."""
        parts = self._parts
        name, now = event_filter.robot, utc_now()
        robot = parts[RobotRegistry].get(name)
        events = [
            system_event("stop", parts[Stopper].state(robot.namespace), now, robot=name),
            system_event("battery_publisher", robot.publisher.document(), now, robot=name),
        ]
        servers = parts[ActionRegistry].servers_of(name)
        events.append(system_event("docking", servers._asdict(), now, robot=name))
        events += [system_event("action_server", state, now, action_name=state.action_name) for state in servers]
        if (simulator := parts[Simulators].document(name)) is not None:
            events.append(system_event("simulator", simulator, now, robot=name))
        wanted = [event for event in events if event_filter.covers(event)]
        if "robots" in event_filter.topics:
            grant = event_filter.grant or UNLIMITED
            wanted.append(
                fleet_event("robots", now, narrow_robots, robots=parts[Fleet].documents(grant=grant), gone=[])
            )
            wanted.append(fleet_event("alerts", now, narrow_alerts, alerts=parts[AlertBoard].documents(grant)))
            wanted.append(fleet_event("approvals", now, narrow_approvals, approvals=parts[Approvals].documents(grant)))
        return wanted

"""Opens what is known of all robots: their states, alerts and poses, and what watches them."""

from contextlib import AsyncExitStack, ExitStack
from functools import partial

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.fleet.alert import Acknowledgement
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.findings import claimed_twice
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.graph_watch import GraphWatch
from dock_gateway.fleet.pose_recorder import PoseRecorder
from dock_gateway.fleet.scene_board import SceneBoard
from dock_gateway.fleet.wheels_watch import WheelsWatch
from dock_gateway.gateways.gateways import Gateways
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.labels import Labels
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.on_demand import OnDemand
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.scene_port import MapPort, PosePort
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedEntries


def open_fleet(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the watches on wheels and on the graph, the poses, the alerts and the states of all robots."""
    settings, robots, actions = parts[Settings], parts[RobotRegistry], parts[ActionRegistry]
    _watch_wheels(parts, stack)
    _listen_to_poses(parts, stack)
    # Mistakes on the graph are also named where a goal is aborted because of them.
    graph_watch = parts.add(GraphWatch, GraphWatch(settings, parts[Bridge], robots, parts[RobotActions]))
    actions.remarks.append(graph_watch.remark)
    _open_alerts(parts, stack)
    fleet = Fleet(
        settings,
        parts[Fanout],
        robots=robots,
        actions=actions,
        robot_actions=parts[RobotActions],
        hints=parts[DockingHints],
        interlock=parts[Interlock],
        simulators=parts[Simulators],
        last_goals=parts[LastGoals],
        labels=parts[Labels],
        alerts=parts[AlertBoard],
    )
    parts.add(Fleet, closed_by(stack, fleet))


def _watch_wheels(parts: Parts, stack: AsyncExitStack) -> None:
    """Make what stops robots whose commands end."""
    settings, bridge, robots = parts[Settings], parts[Bridge], parts[RobotRegistry]

    async def name(robot: str, publisher: bytes) -> str | None:
        topic = settings.resolve(settings.cmd_vel_topic, robot)
        found = await bridge.call(lambda: read_topic(bridge.node, topic))
        return next((each.node for each in found.publishers if each.gid == publisher), None)

    def listen(robot: str) -> ExitStack:
        wheels = robots.get(robot).wheels
        wheels.listen()
        listener = robots.velocities.watch(settings.resolve(settings.cmd_vel_topic, robot), wheels.hear)
        wheels.catch_up = listener.catch_up
        port = ExitStack()
        port.callback(listener.close)
        port.callback(wheels.stop_listening)
        return port

    watch = closed_by(stack, WheelsWatch(parts[ActionRegistry], robots, name, settings.command_timeout))
    closed_by(stack, OnDemand(bridge, watch, "commands", listen))
    parts.add(WheelsWatch, watch)


def _listen_to_poses(parts: Parts, stack: AsyncExitStack) -> None:
    """Subscribe to the poses of the robots that streams, maps or the history want."""
    settings, robots = parts[Settings], parts[RobotRegistry]

    def listen(kind: type[PosePort], hearers: PoseRecorder | SceneBoard) -> None:
        def port(robot: str) -> PosePort:
            resolve = partial(settings.resolve, namespace=robot)
            return kind(robots.topics, robot, resolve, hearers.hear, stop_topic=resolve(settings.stop_state_topic))

        closed_by(stack, OnDemand(robots.topics.bridge, hearers, "poses", port))

    listen(MapPort, closed_by(stack, SceneBoard(parts[Fanout], robots.namespaces)))
    if settings.store_poses:
        recorder = PoseRecorder(parts[ActionRegistry].running, robots.owner, parts[History].record_event)
        listen(PosePort, closed_by(stack, recorder))


def _open_alerts(parts: Parts, stack: AsyncExitStack) -> None:
    settings, history = parts[Settings], parts[History]
    gateways, graph_watch, wheels_watch = parts[Gateways], parts[GraphWatch], parts[WheelsWatch]
    alerts = AlertBoard(
        parts[Fanout],
        SharedEntries(history.documents("acknowledgement", Acknowledgement)),
        low_battery=settings.low_battery,
        incident=lambda: history.incident,
        findings=lambda: [*graph_watch.findings, *claimed_twice(gateways.conflict), *wheels_watch.findings],
        only=parts[RobotRegistry].namespaces if parts[Share].limited else None,
    )
    parts.add(AlertBoard, closed_by(stack, alerts))
    parts.add(Alerts, alerts)

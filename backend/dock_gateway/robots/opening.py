"""Opens the robots."""

from contextlib import AsyncExitStack
from functools import partial

from dock_gateway.core.event import robot_event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Json, fragment
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.calibration import Calibrations
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.on_demand import OnDemand
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import RobotLabels, Robots
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.scene_port import ScenePort
from dock_gateway.ros.velocity import VelocityListener
from dock_gateway.settings import Settings
from dock_gateway.storage import History


async def open_robots(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the robots, their labels, and their topics that are subscribed to only on demand."""
    settings, bridge, fanout, history = parts[Settings], parts[Bridge], parts[Fanout], parts[History]
    last_goals = parts.add(LastGoals, closed_by(stack, LastGoals(history)))
    robots = RobotRegistry(settings, bridge, fanout, parts[Interlock], last_goals, share=parts[Share])
    parts.add(RobotRegistry, closed_by(stack, robots))
    parts.add(Robots, robots)
    labels = parts.add(Labels, closed_by(stack, Labels(history.documents("label", RobotLabel), robots.namespaces)))
    parts.add(RobotLabels, labels)
    await labels.open()
    parts.add(Simulators, closed_by(stack, Simulators(fanout, robots)))
    parts.add(Calibrations, Calibrations(settings, bridge))
    _subscribe_on_demand(settings, bridge, fanout, robots, stack)


def _subscribe_on_demand(
    settings: Settings, bridge: Bridge, fanout: Fanout, robots: RobotRegistry, stack: AsyncExitStack
) -> None:
    def scene(robot: str) -> ScenePort:
        resolve = partial(settings.resolve, namespace=robot)
        return ScenePort(robots.topics, robot, resolve, fanout.publish, stop_topic=resolve(settings.stop_state_topic))

    def velocity(robot: str) -> VelocityListener:
        def hear(message: Json, stamp_ns: int) -> None:
            fanout.publish(
                robot_event("cmd_vel", fragment(message), fanout.clock.stamp(stamp_ns), stamp_ns, robot=robot)
            )

        return robots.velocities.listen(settings.resolve(settings.cmd_vel_topic, robot), hear)

    closed_by(stack, OnDemand(bridge, fanout, "scene", scene))
    closed_by(stack, OnDemand(bridge, fanout, "cmd_vel", velocity))

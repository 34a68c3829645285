"""Scans the ROS graph, and gives what it found to the parts that follow it."""

import asyncio
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager

from dock_gateway.core.errors import GatewayError
from dock_gateway.fleet.departures import Departures
from dock_gateway.fleet.graph_watch import GraphWatch
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Scan, scan
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# Seconds between two scans of the graph.
SCAN_INTERVAL = 1.0
# Seconds between two scans while something on the graph is still to be registered.
PAUSE = 0.1


async def scan_graph(parts: Parts) -> None:
    """Scan the graph periodically: actions and robots join and leave, topics are joined, mistakes are found."""
    bridge, robots, actions = parts[Bridge], parts[RobotRegistry], parts[ActionRegistry]
    departures = Departures(
        robots,
        actions,
        parts[RobotActions],
        parts[Interlock],
        parts[LastGoals],
        forget_after=parts[Settings].forget_robot_after,
    )

    async def velocities(found: Scan) -> None:
        await robots.velocities.update(found.topics)

    async def topics(found: Scan) -> None:
        await robots.topics.update(found.topics)

    async def leave(found: Scan) -> None:
        await departures.check(found, time.monotonic())

    steps = (actions.update, robots.update, velocities, topics, parts[GraphWatch].update, robots.scanned, leave)
    while True:
        more = False
        with _logged():
            found = await bridge.call(lambda: scan(bridge.node))
            for step in steps:
                with _logged():
                    more = bool(await step(found)) or more
        await asyncio.sleep(PAUSE if more else SCAN_INTERVAL)


@contextmanager
def _logged() -> Iterator[None]:
    """Log an exception instead of raising it, so that a failure does not affect the rest."""
    try:
        yield
    except GatewayError as error:
        log.warning("cannot read the ROS graph: %s", error.detail)
    except Exception:
        log.exception("while reading the ROS graph")

"""Opens what stops robots."""

from contextlib import AsyncExitStack

from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.publishing import Publishing
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings
from dock_gateway.stop.stop_of_all import StopOfAll
from dock_gateway.stop.stopper import Stopper


def open_stop(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the stop of a robot, and that of all. Requests for approval, and what clients publish, end with one."""
    robots, interlock = parts[RobotRegistry], parts[Interlock]
    stopper = closed_by(stack, Stopper(robots, parts[ActionRegistry], interlock, share=parts[Share]))
    parts.add(Stopper, stopper)
    stopper.on_stop.append(parts[Approvals].drop)
    stopper.on_stop.append(parts[Publishing].withdraw)
    parts.add(StopOfAll, closed_by(stack, StopOfAll(parts[Settings], robots, interlock, stopper)))

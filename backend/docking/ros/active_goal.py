"""The goal that is running."""

from collections.abc import Callable
from dataclasses import dataclass, field

from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future

from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.nearest_dock import NearestDock
from docking.goal.outcome import Outcome


@dataclass(eq=False)
class Execution:
    """A goal that was accepted.

    Attributes:
        handle: What its action server knows it by.
        goal_id: The same as text.
        goal: The goal itself.
        end: Ends it, on the server it came to.
        nearest: Finds the dock, for a goal that asks for the nearest one; None once it is known.
        waits_for_clock: Whether it came before a simulated clock said anything, so that it begins when that does.
        ended: Holds the outcome in the end.
    """

    handle: ServerGoalHandle
    goal_id: str
    goal: Goal
    end: Callable[[Outcome], None]
    nearest: NearestDock | None = None
    waits_for_clock: bool = False
    ended: Future = field(default_factory=Future)


@dataclass
class ActiveGoal:
    """One goal at a time, whichever of the process's servers it came to.

    Attributes:
        running: None while no goal runs.
        memory: What the goals so far tell of the dock.
    """

    running: Execution | None = None
    memory: DockMemory = field(default_factory=DockMemory)

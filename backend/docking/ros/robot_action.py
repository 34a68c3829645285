"""An action that drives the robot: all that docking and undocking differ in."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from docking.core.errors import Stage
from docking.core.footprint import Footprint
from docking.core.transform import Transform
from docking.goal.admission import Purpose
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.parameters import DockPlace, ServerSettings, StagingGoal
from docking.ros.sensors import Sensor

S = TypeVar("S", bound=ServerSettings)


class RobotAction(ABC, Generic[S]):
    """One action. `settings` are the parameters of its node; those for a goal come from `at_dock`.

    Attributes:
        node_name: The name of the node that serves it.
        action_name: The name of the action.
        action_type: Its type.
        purpose: What its goals may ask for.
        settings_type: The dataclass of the node's parameters.
        progress: A stage, and what is logged once a second at it.
        success: What is logged at the end.
        ends_with_charge: Whether a message of a charging battery is looked at as soon as it comes.
    """

    node_name: str
    action_name: str
    action_type: type
    purpose: Purpose
    settings_type: type[S]
    progress: tuple[Stage, str]
    success: Sequence[str]
    ends_with_charge = False

    @abstractmethod
    def needs(self, settings: S) -> frozenset[Sensor]:
        """The sensors that a goal needs."""

    @abstractmethod
    def make_goal(self, settings: S, memory: DockMemory, started_at: float) -> Goal:
        """A goal that begins at a moment, with what is remembered of the dock."""

    @abstractmethod
    def control_period(self, settings: S) -> float:
        """Seconds between two control steps."""

    def at_dock(self, settings: S, dock_name: str) -> S:
        """The parameters for a goal at a dock.

        Raises:
            DockNotInDb: There is no dock of that name.
        """
        return settings

    def uses_frames(self, settings: S) -> bool:
        """Whether goals may need the transforms between frames."""
        return self.detects_marker(settings) or settings.collision.needs_tf

    def detects_marker(self, settings: S) -> bool:
        """Whether goals go by detections of a marker."""
        return Sensor.MARKER in self.needs(settings)

    def marker_tilt(self, settings: S) -> Transform:
        """How the marker's axes are turned; see `Sensors`."""
        return Transform()

    def dock_types(self, settings: S) -> Sequence[str]:
        """The types of docks that have parameters of their own."""
        return ()

    def place(self, settings: S) -> DockPlace | None:
        """Where the database has the goal's dock; None where it does not."""
        return None

    def navigates(self, settings: S) -> bool:
        """Whether goals may begin with a navigation to a staging pose."""
        return False

    def staging(self, settings: S) -> StagingGoal | None:
        """Where the goal's navigation leads; None where there is none."""
        return None

    def outline(self, settings: S) -> Footprint | None:
        """The robot's footprint; None where it is not published."""
        return None

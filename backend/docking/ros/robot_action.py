"""An action that drives the robot: all that docking and undocking differ in."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from docking.core.errors import Stage
from docking.goal.admission import Purpose
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.parameters import ServerSettings
from docking.ros.sensors import Sensor

S = TypeVar("S", bound=ServerSettings)


class RobotAction(ABC, Generic[S]):
    """One action. `settings` are the parameters of its node, and those for a goal: see `ServerSettings.at_dock`.

    Attributes:
        node_name: The name of the node that serves it.
        action_name: The name of the action.
        action_type: Its type.
        purpose: What its goals may ask for.
        settings_type: The dataclass of the node's parameters.
        progress: A stage, and the log line that it repeats once a second.
        success: Log lines at the end.
        ends_with_charge: Whether a message of a charging battery is looked at as soon as it comes.
        shows_footprint: Whether the robot's footprint is published.
        knows_docks: Whether there is a file of docks, which can be read again.
    """

    node_name: str
    action_name: str
    action_type: type
    purpose: Purpose
    settings_type: type[S]
    progress: tuple[Stage, str]
    success: Sequence[str]
    ends_with_charge = False
    shows_footprint = False
    knows_docks = False

    @abstractmethod
    def needs(self, settings: S) -> frozenset[Sensor]:
        """The sensors that a goal needs."""

    @abstractmethod
    def make_goal(self, settings: S, memory: DockMemory, started_at: float) -> Goal:
        """Return a goal that starts at a moment, with the knowledge of the dock from earlier goals."""

    def uses_frames(self, settings: S) -> bool:
        """Whether goals may need the transforms between frames."""
        return self.detects_marker(settings) or settings.collision.needs_tf

    def detects_marker(self, settings: S) -> bool:
        """Whether goals go by detections of a marker."""
        return Sensor.MARKER in self.needs(settings)

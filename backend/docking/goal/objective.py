"""The objective of a goal: when it is reached, how long its stages may take, and the memory of the dock."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field

from docking.core.battery import BatteryReading
from docking.core.errors import DockingError, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.goal.dock_memory import DockMemory
from docking.parameters import ChargingSettings, RecoverySettings, Timeouts


@dataclass(frozen=True, slots=True)
class Deadline:
    """The time limit of a stage.

    Attributes:
        parameter: The name of the limit.
        seconds: The limit.
        error: The error after the time limit.
        message: The same as the end of a sentence.
    """

    parameter: str
    seconds: float
    error: type[DockingError]
    message: str


@dataclass(frozen=True, slots=True)
class Progress:
    """The progress of a plan.

    Attributes:
        arrived: Whether it is at its last stage.
        finished: Whether that is done, too.
        docked: Where base_link is when docked, in odom; None where that is not known.
        turn: How far the dock's marker is taken to be turned, in rad.
        camera: How far the camera is from where tf has it, in base_link; no way where nothing was measured.
    """

    arrived: bool
    finished: bool
    docked: Pose | None
    turn: float = 0.0
    camera: Pose = field(default_factory=Pose)


class Objective(ABC):
    """Docking or undocking; a new one is made for each goal.

    Attributes:
        timeouts: The time limits of every goal.
        max_retries: How often to back off and try again.
        recovery: Moves on the contacts and after the last attempt; None without any.
        memory: Knowledge of the dock that is kept from goal to goal.
        docks: Whether the robot is docked when the goal is reached.
        doubt: What seems wrong with the charge, as a sentence; empty where nothing does.
        unsure: Why it is not certain that the robot is on its dock, which it is to leave, as a sentence; empty where it
            is. A robot that may be anywhere drives slowly.
        slowdown_radius: The last part of the way to the docked pose, in m, that is driven slowly.
    """

    docks: bool
    max_retries = 0
    recovery: RecoverySettings | None = None
    slowdown_radius = 0.0
    doubt = ""
    unsure = ""

    def __init__(self, timeouts: Timeouts, memory: DockMemory | None, charging: ChargingSettings | None) -> None:
        """Begin.

        Args:
            timeouts: The time limits.
            memory: Knowledge from earlier goals; None without any.
            charging: How charging is detected; None uses the battery's status.
        """
        self.timeouts = timeouts
        self.memory = memory or DockMemory()
        self._charging = charging or ChargingSettings()

    @abstractmethod
    def is_reached(self, observation: Observation, battery: BatteryReading | None, progress: Progress) -> bool:
        """The success test; called at each step.

        Args:
            observation: Current sensor readings.
            battery: The latest reading, None where it is stale.
            progress: How far the plan has come.

        Raises:
            DockingError: The goal can never be reached.
        """

    @abstractmethod
    def deadline(self, stage: Stage, finished: bool) -> Deadline | None:
        """The time limit of a stage; None where it has none."""

    @property
    def search(self) -> Deadline | None:
        """The time limit of driving about to find the dock, at a stage; None where it has none."""
        return None

    def limit(self, stage: Stage) -> float:
        """The longest that a stage may take, in s, but for waiting and for a charge that is not stable yet."""
        deadline = self.deadline(stage, False)
        return math.inf if deadline is None else deadline.seconds

    def held(self, failures: int) -> float:
        """The longest that a goal may stand still for a charge that breaks off, in s, beyond the limits of its stages.

        Args:
            failures: Number of stages that may fail.
        """
        return 0.0

    @property
    def flickers(self) -> bool:
        """Whether the charge comes and goes, so that waiting for it counts towards the time limit, too."""
        return False

    @property
    def needs_battery(self) -> bool:
        """Whether the robot waits without a battery message: not where the dock does not charge."""
        return self._charging.charges

    def holds(self, stage: Stage) -> bool:
        """Whether the robot is to stand still at this stage, as the goal may be reached in a moment."""
        return False

    def reword(self, failure: DockingError) -> DockingError:
        """Return the consequence of a failure for this goal."""
        return failure

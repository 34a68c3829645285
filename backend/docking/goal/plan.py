"""The interface of plans: the stages of docking with one kind of sensor, and the behavior of each."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, runtime_checkable

from docking.core.errors import DockingError, FailedToControl, FailedToDetectDock, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.dock_estimate import Spread
from docking.goal.behavior import Behavior
from docking.goal.doubts import Doubts
from docking.parameters import MotionLimits


@dataclass(frozen=True, slots=True)
class KnownPoses:
    """Estimated poses of the dock, in the frame odom; None if unknown.

    Attributes:
        dock: Of base_link when docked, by the last detection alone.
        filtered_dock: The same by all detections.
        staging: Of base_link in front of the dock.
        note: A remark about unusual detections, as a sentence; empty without one.
        explores: Whether the robot drives about to find the dock: that has a time limit of its own.
        turn: How far the marker is taken to be turned on its dock, in rad.
        camera: How far the camera is from where tf has it, in base_link; no way where nothing was measured.
        uncertainty: How far the docked pose may be off without anyone knowing, in m: the robot drives slowly sooner.
        pushes: Whether the robot is to push against the dock, where its wheels may stand.
        doubt: Why the robot must stand still, as what is seen does not move as it drives; empty if it may drive.
        proven: Whether what is seen has moved as the robot drove, or nothing is seen now; if not, it drives slowly.
        late: How much older than known the detections may be, in s.
    """

    dock: Pose | None = None
    filtered_dock: Pose | None = None
    staging: Pose | None = None
    note: str = ""
    explores: bool = False
    turn: float = 0.0
    camera: Pose = field(default_factory=Pose)
    pushes: bool = False
    uncertainty: float = 0.0
    doubt: str = ""
    proven: bool = True
    late: float = 0.0


class NothingLeftToTry(FailedToControl):
    """The plan knows no other place to dock at."""


class DockTarget(ABC):
    """The dock as the target of the behaviors of several stages."""

    @cached_property
    def doubts(self) -> Doubts:
        """The doubts of the way so far."""
        return Doubts()

    @property
    @abstractmethod
    def docked(self) -> Pose | None:
        """The pose of base_link when docked, in odom; None before the dock was seen."""

    @property
    @abstractmethod
    def seen_at(self) -> float:
        """The time when the dock was seen last."""

    unseen = "the dock was out of sight"
    """What it means that `seen_at` stays the same, as a part of a sentence."""

    @property
    def spread(self) -> Spread:
        """The spread of the docked pose: small enough, unless a plan knows better."""
        return Spread(0.0, 0.0)

    @property
    def period(self) -> float:
        """Seconds between two detections, usually; 0 if that is not known."""
        return 0.0

    @property
    def yaw_bias(self) -> float:
        """The curvature of the way, in rad/m, that odometry does not see."""
        return 0.0

    @property
    def stalled(self) -> bool:
        """Whether the joints of the wheels tell that these stall."""
        return False

    @property
    def disputed(self) -> bool:
        """Whether the last detections agree on another pose than what was known before."""
        return False


class Plan(Protocol):
    """A plan to dock by one kind of sensor; a new one is made for each goal.

    Attributes:
        stages: In their order. After the last one the robot stands still until the battery charges.
        motion: Limits of the robot's motion; None leaves velocities as they are and needs no odometry.
        lost: The error if the dock cannot be found again after it was seen.
        poses: Current estimate of the dock.
    """

    @property
    def stages(self) -> tuple[Stage, ...]: ...  # noqa: D102 - see above

    @property
    def motion(self) -> MotionLimits | None: ...  # noqa: D102

    @property
    def lost(self) -> type[DockingError]: ...  # noqa: D102

    @property
    def poses(self) -> KnownPoses: ...  # noqa: D102

    def observe(self, observation: Observation) -> None:
        """Take notice, whatever the stage; called once before the controller's step."""

    def controller(self, stage: Stage) -> Behavior:
        """A new controller for one of the stages, or for RETRY."""


@runtime_checkable
class RecoveringPlan(Protocol):
    """A plan that also knows what to do at the dock when it does not charge, and how to leave it in the end."""

    def correct(self, number: int) -> Behavior:
        """A small move on the contacts: a little back, a little turn, and on again.

        Args:
            number: Of the move in this goal, from 1.
        """

    def way_back(self) -> Behavior:
        """From the dock to the staging pose, or a little away from it where that is not known."""


class SingleStage:
    """The plan of a behavior that is the only one and needs no odometry, such as `Rotate`."""

    stages = (Stage.CONTROLLING,)
    motion = None
    lost = FailedToDetectDock
    poses = KnownPoses()

    def __init__(self, controller: Behavior) -> None:
        self._controller = controller

    def observe(self, observation: Observation) -> None:
        """Nothing to remember."""

    def controller(self, stage: Stage) -> Behavior:
        """The only one."""
        return self._controller

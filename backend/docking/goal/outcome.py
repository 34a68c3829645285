"""The result of a step of a goal: the next command, or the outcome."""

import enum
from dataclasses import dataclass, field

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose
from docking.core.observation import Velocity


@dataclass(frozen=True)
class Command:
    """The goal goes on.

    Attributes:
        stage: The current stage.
        velocity: The commanded velocity until the next step.
        error_code: NONE, or why the goal waits or tries again.
        error_msg: The same as a sentence.
        retries: Number of retries.
        dock_pose: Of base_link when docked, by the last detection alone; in odom, as the next two.
        filtered_dock_pose: The same by all detections.
        staging_pose: Of base_link in front of the dock.
        yields: Whether another server drives the robot, so that no velocity is to be published.
        note: A remark about unusual detections of the dock, as a sentence; empty without one.
    """

    stage: Stage
    velocity: Velocity
    error_code: ErrorCode = ErrorCode.NONE
    error_msg: str = ""
    retries: int = 0
    dock_pose: Pose | None = None
    filtered_dock_pose: Pose | None = None
    staging_pose: Pose | None = None
    yields: bool = False
    note: str = ""


class End(enum.StrEnum):
    """The ends of a goal, in the words of ROS."""

    SUCCEEDED = "SUCCEEDED"
    CANCELED = "CANCELED"
    ABORTED = "ABORTED"

    @property
    def stage(self) -> Stage:
        """The stage that stands for this end."""
        return Stage(self.value)


@dataclass(frozen=True)
class Outcome:
    """The goal is over, and the wheels stand still.

    Attributes:
        end: How.
        error_code: NONE unless it was aborted.
        error_msg: The same as a sentence, with the doubts.
        retries: Number of retries.
        doubts: What seemed wrong on the way, a sentence each.
    """

    end: End
    error_code: ErrorCode = ErrorCode.NONE
    error_msg: str = ""
    retries: int = 0
    doubts: tuple[str, ...] = field(default=(), compare=False)

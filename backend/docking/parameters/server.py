"""The common parameters of both action servers."""

import enum
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Self

from docking.core.parameter import Meanings, NodeSettings, Value, choice, group, number, string, switch
from docking.parameters.charging import ChargingSettings
from docking.parameters.collision import CollisionSettings, Outline
from docking.parameters.detector import DetectorSettings
from docking.parameters.limits import BACKWARDS, MotionLimits
from docking.parameters.nav2 import read_nav2
from docking.parameters.navigation import StagingGoal
from docking.parameters.search import DockPlace
from docking.parameters.timeouts import Timeouts
from robot_io.transform import Transform

TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


class GoalPolicy(enum.StrEnum):
    """The policy for a goal that arrives while another one runs."""

    REJECT = "reject"
    PREEMPT = "preempt"


class StampedCmdVel(enum.StrEnum):
    """Whether velocities have a stamp."""

    AUTO = "auto"
    """As the subscribers of `cmd_vel` want it, without one while there are none."""
    TRUE = "true"
    FALSE = "false"


def read_topics(text: str) -> tuple[str, ...]:
    """Read names of topics, separated by commas.

    Raises:
        ValueError: One of them is no name; the caller adds the subject to the message.
    """
    names = tuple(part.strip() for part in text.split(",") if part.strip())
    for name in names:
        if not TOPIC.fullmatch(name):
            raise ValueError(f"has {name!r}, which is no name of a topic")
    return names


@dataclass(frozen=True)
class ServerSettings(NodeSettings):
    """The parameters of both action servers."""

    goal_policy: GoalPolicy = choice(
        GoalPolicy.REJECT,
        "What happens to a goal that arrives while another one runs: it is rejected, or it preempts the "
        "other one, which is aborted.",
    )
    autostart: bool = switch(
        True,
        "Whether the node configures and activates itself at its start; if not, `ros2 lifecycle set` or a manager "
        "does.",
    )
    timeouts: Timeouts = group(Timeouts)
    charging: ChargingSettings = group(ChargingSettings)
    controller_frequency: float = number(
        20.0, 5.0, 100.0, "Hz", "Rate at which velocities are computed and published; rotate publishes at 10 Hz."
    )
    motion: MotionLimits = group(MotionLimits)
    enable_stamped_cmd_vel: StampedCmdVel = choice(
        StampedCmdVel.AUTO,
        "Whether cmd_vel is a TwistStamped: as its subscribers want it, or always, or never. `true` and `false` may be "
        "booleans.",
    )
    stop_topics: str = string(
        "",
        "topic, topic, …",
        "More topics like stop_latched (std_msgs/Bool), such as that of an emergency stop, separated by commas; true "
        "on any of them stops the robot.",
        read_topics,
    )
    frame_prefix: str = string(
        "",
        "robot1/",
        "Prefix of frame names in all messages, received and published; not added to names that have it already.",
    )
    outline: Outline = group(Outline)
    collision: CollisionSettings = group(CollisionSettings)

    # No parameters, but what `at_dock` finds out of the dock that a goal names.
    staging_goal: StagingGoal | None = None
    place: DockPlace | None = None
    choices: tuple[DockPlace, ...] = ()  # for a goal that asks for the nearest dock

    def at_dock(self, name: str) -> Self:
        """The settings for a goal; only docking knows docks.

        Args:
            name: The dock that the goal names, or describes as JSON; may be empty.

        Raises:
            DockNotInDb: There is no such dock.
            DockNotValid: It is described, and can be none.
        """
        return self

    @property
    def navigates(self) -> bool:
        """Whether goals may begin with a navigation to a staging pose."""
        return False

    @property
    def dock_types(self) -> tuple[str, ...]:
        """The types of docks that have parameters of their own."""
        return ()

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that tell whether the wheels stall."""
        return ()

    @property
    def switched(self) -> DetectorSettings:
        """The settings that switch the detector of the marker on and off."""
        return DetectorSettings()

    @property
    def marker_tilt(self) -> Transform:
        """The rotation of the axes of the dock's marker; see `Sensors`."""
        return Transform()

    @classmethod
    def read_given(cls, given: Mapping[str, Value], resolve: Callable[[str], str]) -> Meanings:
        """Return the meaning of given parameters of nav2's docking server."""
        return read_nav2(given, resolve)

    @property
    def control_period(self) -> float:
        """Seconds between two velocities."""
        return 1.0 / self.controller_frequency

    def find_conflict(self) -> str | None:
        """Return why these values cannot work together."""
        timeouts, motion = self.timeouts, self.motion
        return (
            find_disorder(
                "battery_lost_after", timeouts.battery_lost_after, "battery_stale_after", timeouts.battery_stale_after
            )
            or find_disorder("v_linear_max", motion.v_linear_max, "v_linear_min", motion.v_linear_min)
            or find_disorder("v_angular_max", motion.v_angular_max, "v_angular_min", motion.v_angular_min)
        )

    def find_backing_shortage(self, name: str, timeout: float, distance: float) -> str | None:
        """Return why a time limit is too short to back out over a distance in m; None where it is not."""
        speed = self.motion.v_linear_back
        where = f"{distance:g} m (staging_x_offset) backwards at {speed:.3g} m/s ({BACKWARDS:g} of v_linear_max)"
        return find_shortage(name, timeout, distance / speed, where)


def find_disorder(greater: str, high: float, smaller: str, low: float) -> str | None:
    """Return why two values are in the wrong order; None where they are not."""
    return None if high >= low else f"{greater} ({high:g}) must not be below {smaller} ({low:g})"


def find_shortage(name: str, timeout: float, needed: float, where: str) -> str | None:
    """Return why a time limit is too short for what needs some seconds; None where it is not."""
    return None if needed <= timeout else f"{name} ({timeout:g} s) is too short: {where} takes {needed:.1f} s"

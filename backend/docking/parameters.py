"""The parameters of the action servers: names, types, units, ranges and defaults in one table."""

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

from docking.core.dock import Dock
from docking.core.footprint import ROBOT_RADIUS, Footprint, read_footprint, round_footprint
from docking.estimation.beacon_filter import Receivers
from docking.goal.admission import GoalPolicy
from docking.goal.engine import Limits
from docking.goal.limiter import MotionLimits


class ControllerName(enum.StrEnum):
    """What drives the robot to its dock."""

    ROTATE = "rotate"
    DOCK_POSE = "dock_pose"
    INFRARED = "infrared"


@dataclass(frozen=True)
class FloatParameter:
    """A double with a closed range."""

    name: str
    default: float
    minimum: float
    maximum: float
    unit: str
    description: str


@dataclass(frozen=True)
class IntegerParameter:
    """An integer with a closed range; the unit is empty where it only counts."""

    name: str
    default: int
    minimum: int
    maximum: int
    unit: str
    description: str


@dataclass(frozen=True)
class ChoiceParameter:
    """A string out of a few."""

    name: str
    default: str
    choices: tuple[str, ...]
    description: str


@dataclass(frozen=True)
class TextParameter:
    """A string of a certain form; where it is not, `read` raises ValueError with a sentence's second half."""

    name: str
    default: str
    form: str
    read: Callable[[str], object]
    description: str


Parameter = FloatParameter | IntegerParameter | ChoiceParameter | TextParameter

_GOAL: tuple[Parameter, ...] = (
    ChoiceParameter(
        "goal_policy",
        "reject",
        ("reject", "preempt"),
        "What happens to a goal that arrives while another one runs: it is rejected, or it preempts the "
        "other one, which is aborted.",
    ),
    FloatParameter(
        "battery_stale_after",
        2.0,
        0.1,
        3600.0,
        "s",
        "Time without a battery message after which the wheels stop; the goal continues with the next message.",
    ),
    FloatParameter(
        "battery_lost_after",
        60.0,
        0.1,
        86400.0,
        "s",
        "Time without a battery message, counted from the goal's acceptance, after which it is aborted. "
        "Not below battery_stale_after.",
    ),
    FloatParameter(
        "goal_timeout", 0.0, 0.0, 86400.0, "s", "Maximum duration of a goal, after which it is aborted; 0: no limit."
    ),
)

_MOTION: tuple[Parameter, ...] = (
    FloatParameter(
        "controller_frequency", 20.0, 5.0, 100.0, "Hz", "Rate at which velocities are computed and published."
    ),
    FloatParameter(
        "v_linear_max", 0.26, 0.01, 2.0, "m/s", "Maximum linear velocity, forwards and backwards (linear.x)."
    ),
    FloatParameter(
        "v_angular_max", 1.0, 0.05, 4.0, "rad/s", "Maximum angular velocity, in both directions (angular.z)."
    ),
    FloatParameter("a_linear_max", 0.5, 0.05, 5.0, "m/s²", "Maximum linear acceleration; does not apply to a stop."),
    FloatParameter(
        "a_angular_max", 2.0, 0.1, 20.0, "rad/s²", "Maximum angular acceleration; does not apply to a stop."
    ),
    FloatParameter("odometry_timeout", 1.0, 0.1, 60.0, "s", "Time without odometry after which the goal is aborted."),
    FloatParameter(
        "blocked_after",
        2.0,
        0.5,
        60.0,
        "s",
        "Time over which commanded and measured motion are compared; if they differ too much, the robot is blocked.",
    ),
    FloatParameter(
        "staging_x_offset",
        -0.7,
        -3.0,
        -0.3,
        "m",
        "Distance from the docked pose to the staging pose along the robot's x axis; negative is in front of the dock.",
    ),
)

DOCK_SERVER: tuple[Parameter, ...] = (
    *_GOAL,
    ChoiceParameter(
        "controller",
        "rotate",
        ("rotate", "dock_pose", "infrared"),
        "How the robot is driven: turning on the spot as in the tutorial, by the pose of a marker on the "
        "dock, or by three infrared receivers. All parameters after rotate_speed apply to the last two.",
    ),
    FloatParameter(
        "robot_radius", ROBOT_RADIUS, 0.01, 5.0, "m", "Radius of a round robot, around base_link; for maps only."
    ),
    TextParameter(
        "footprint",
        "",
        "[[x, y], …]",
        read_footprint,
        "Outline of a robot that is not round: 3 to 100 points in base_link, in m, in their order around the robot. "
        "If it is empty, robot_radius counts.",
    ),
    FloatParameter(
        "rotate_speed",
        0.15,
        -2.0,
        2.0,
        "rad/s",
        "Angular velocity of the controller rotate (angular.z); counter-clockwise is positive.",
    ),
    *_MOTION,
    FloatParameter(
        "v_linear_min",
        0.04,
        0.005,
        0.5,
        "m/s",
        "Minimum linear velocity, also used for the last part before contact.",
    ),
    FloatParameter("search_speed", 0.6, 0.05, 4.0, "rad/s", "Angular velocity while the robot searches for the dock."),
    IntegerParameter(
        "max_retries", 3, 0, 100, "", "Maximum number of retries; the robot backs off before each of them."
    ),
    FloatParameter("initial_perception_timeout", 20.0, 0.1, 3600.0, "s", "Time limit for finding the dock."),
    FloatParameter("staging_timeout", 60.0, 0.1, 3600.0, "s", "Time limit for driving to the staging pose."),
    FloatParameter(
        "dock_approach_timeout", 30.0, 0.1, 3600.0, "s", "Time limit for driving from the staging pose to the dock."
    ),
    FloatParameter(
        "wait_charge_timeout", 5.0, 0.1, 3600.0, "s", "Time limit for the battery to start charging on the dock."
    ),
    FloatParameter("retry_timeout", 30.0, 0.1, 3600.0, "s", "Time limit for backing off."),
    FloatParameter(
        "external_detection_timeout",
        2.0,
        0.1,
        60.0,
        "s",
        "Time without a detection of the marker or the beacon, during the approach, after which the dock is lost.",
    ),
    FloatParameter(
        "external_detection_translation_x",
        -0.2,
        -2.0,
        0.0,
        "m",
        "Position of the docked robot relative to the marker or the beacon, along the marker's x axis, "
        "which points into the dock.",
    ),
    FloatParameter(
        "external_detection_translation_y",
        0.0,
        -1.0,
        1.0,
        "m",
        "The same, along the marker's y axis.",
    ),
    FloatParameter(
        "external_detection_rotation_yaw",
        0.0,
        -3.1416,
        3.1416,
        "rad",
        "Heading of the docked robot relative to the marker's x axis.",
    ),
    FloatParameter(
        "infrared_receiver_x",
        0.15,
        -1.0,
        1.0,
        "m",
        "Position of the three infrared receivers: x in base_link.",
    ),
    FloatParameter(
        "infrared_receiver_angle",
        0.349,
        0.05,
        1.5,
        "rad",
        "Angle between straight ahead and the direction of the left or the right receiver.",
    ),
    FloatParameter(
        "infrared_field_of_view",
        0.5,
        0.1,
        3.0,
        "rad",
        "Field of view of each receiver, edge to edge. Not below infrared_receiver_angle.",
    ),
    FloatParameter(
        "infrared_beacon_angle",
        1.047,
        0.1,
        1.57,
        "rad",
        "Angle from the dock's axis to each edge of the beacon's light; the robot locates the axis by this edge.",
    ),
)

UNDOCK_SERVER: tuple[Parameter, ...] = (
    *_GOAL,
    *_MOTION,
    FloatParameter(
        "undocking_timeout",
        20.0,
        0.1,
        3600.0,
        "s",
        "Time limit for backing out until the battery no longer charges.",
    ),
)

FIBONACCI_SERVER: tuple[Parameter, ...] = (
    FloatParameter("step_period", 1.0, 0.01, 60.0, "s", "Time between two numbers."),
)


_ORDERED = (
    ("battery_lost_after", "battery_stale_after", "s"),
    ("v_linear_max", "v_linear_min", "m/s"),
    ("infrared_field_of_view", "infrared_receiver_angle", "rad"),
)
"""What must not be below what, and the unit of both."""


@dataclass(frozen=True)
class DockSettings:
    """The parameters of the docking action server, as the program uses them.

    Attributes:
        goal_policy: What happens to a goal that comes while another one runs.
        limits: Deadlines and retries.
        rotate_speed: Of the controller `rotate`, in rad/s.
        controller: What drives the robot.
        motion: What the robot may do.
        search_speed: In rad/s.
        detection_timeout: external_detection_timeout, in s.
        dock: Where the robot stands when docked, and where it waits in front.
        control_period: Between two velocities, in s.
        footprint: The robot's outline in base_link.
    """

    goal_policy: GoalPolicy
    limits: Limits = field(default_factory=Limits)
    rotate_speed: float = 0.15
    controller: ControllerName = ControllerName.ROTATE
    motion: MotionLimits = field(default_factory=MotionLimits)
    search_speed: float = 0.6
    detection_timeout: float = 2.0
    dock: Dock = field(default_factory=Dock)
    receivers: Receivers = field(default_factory=Receivers)
    control_period: float = 0.05
    footprint: Footprint = field(default_factory=round_footprint)


@dataclass(frozen=True)
class UndockSettings:
    """The parameters of the undocking action server, as the program uses them.

    Attributes:
        goal_policy: What happens to a goal that comes while another one runs.
        limits: Deadlines.
        motion: What the robot may do.
        distance: How far to back out, in m.
        control_period: Between two velocities, in s.
    """

    goal_policy: GoalPolicy
    limits: Limits = field(default_factory=Limits)
    motion: MotionLimits = field(default_factory=MotionLimits)
    distance: float = 0.7
    control_period: float = 0.05


def find_fault(table: tuple[Parameter, ...], values: Mapping[str, object]) -> str | None:
    """What is wrong with some values, beyond their types and ranges; None where nothing is.

    Args:
        table: The parameters there are.
        values: All values known so far, which may be a part of them.
    """
    for parameter in table:
        value = values.get(parameter.name)
        if isinstance(parameter, ChoiceParameter) and value is not None and value not in parameter.choices:
            return f"{parameter.name} is {value!r}, but must be one of: {', '.join(parameter.choices)}"
        if isinstance(parameter, TextParameter) and isinstance(value, str):
            try:
                parameter.read(value)
            except ValueError as error:
                return f"{parameter.name} {error}"
    for greater, smaller, unit in _ORDERED:
        high, low = values.get(greater), values.get(smaller)
        if isinstance(high, float) and isinstance(low, float) and high < low:
            return f"{greater} ({high:g} {unit}) must not be below {smaller} ({low:g} {unit})"
    return None


Part = TypeVar("Part", Limits, MotionLimits, Dock, Receivers)


def dock_settings(values: Mapping[str, object]) -> DockSettings:
    """The settings from a value for each parameter of `DOCK_SERVER`."""
    numbers = _numbers(values)
    return DockSettings(
        goal_policy=GoalPolicy(str(values["goal_policy"])),
        limits=_part(Limits, numbers),
        rotate_speed=numbers["rotate_speed"],
        controller=ControllerName(str(values["controller"])),
        motion=_part(MotionLimits, numbers),
        search_speed=numbers["search_speed"],
        detection_timeout=numbers["external_detection_timeout"],
        dock=_part(Dock, numbers),
        receivers=_part(Receivers, numbers),
        control_period=1.0 / numbers["controller_frequency"],
        footprint=read_footprint(str(values["footprint"])) or round_footprint(numbers["robot_radius"]),
    )


def undock_settings(values: Mapping[str, object]) -> UndockSettings:
    """The settings from a value for each parameter of `UNDOCK_SERVER`."""
    numbers = _numbers(values)
    return UndockSettings(
        goal_policy=GoalPolicy(str(values["goal_policy"])),
        limits=_part(Limits, numbers),
        motion=_part(MotionLimits, numbers),
        distance=-numbers["staging_x_offset"],
        control_period=1.0 / numbers["controller_frequency"],
    )


def _numbers(values: Mapping[str, object]) -> dict[str, float]:
    return {name: value for name, value in values.items() if isinstance(value, (int, float))}


def _part(kind: type[Part], numbers: Mapping[str, float]) -> Part:
    """A dataclass whose fields are named as the parameters are; what is no parameter keeps its default."""
    named: dict[str, Any] = {part.name: numbers[part.name] for part in fields(kind) if part.name in numbers}
    return kind(**named)

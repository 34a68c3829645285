"""The parameters of the action servers: names, types, units, ranges and defaults in one table."""

from collections.abc import Mapping
from dataclasses import dataclass

from docking.admission import GoalPolicy
from docking.goal import Limits


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


Parameter = FloatParameter | IntegerParameter | ChoiceParameter

DOCK_SERVER: tuple[Parameter, ...] = (
    ChoiceParameter(
        "goal_policy",
        "reject",
        ("reject", "preempt"),
        "What happens to a goal that comes while another one runs: it is rejected, or it preempts the other, which is"
        " aborted.",
    ),
    FloatParameter(
        "battery_stale_after",
        2.0,
        0.1,
        3600.0,
        "s",
        "Silence of the battery that stops the wheels; the goal goes on when messages come again.",
    ),
    FloatParameter(
        "battery_lost_after",
        60.0,
        0.1,
        86400.0,
        "s",
        "Silence of the battery, since the goal was accepted, that aborts it. Not below battery_stale_after.",
    ),
    FloatParameter(
        "goal_timeout", 0.0, 0.0, 86400.0, "s", "The longest that a goal may take before it is aborted; 0 is for ever."
    ),
    FloatParameter(
        "rotate_speed",
        0.15,
        -2.0,
        2.0,
        "rad/s",
        "How fast the robot turns on the spot while it looks for the dock (angular.z); counter-clockwise is positive.",
    ),
)

FIBONACCI_SERVER: tuple[Parameter, ...] = (
    FloatParameter("step_period", 1.0, 0.01, 60.0, "s", "The time that each number takes."),
)


@dataclass(frozen=True)
class DockSettings:
    """The parameters of the docking action server, as the program uses them."""

    goal_policy: GoalPolicy
    limits: Limits
    rotate_speed: float


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
    stale, lost = values.get("battery_stale_after"), values.get("battery_lost_after")
    if isinstance(stale, float) and isinstance(lost, float) and lost < stale:
        return f"battery_lost_after ({lost:g} s) must not be below battery_stale_after ({stale:g} s)"
    return None


def dock_settings(values: Mapping[str, object]) -> DockSettings:
    """The settings from a value for each parameter of `DOCK_SERVER`."""
    numbers = {name: value for name, value in values.items() if isinstance(value, float)}
    return DockSettings(
        goal_policy=GoalPolicy(str(values["goal_policy"])),
        limits=Limits(
            battery_stale_after=numbers["battery_stale_after"],
            battery_lost_after=numbers["battery_lost_after"],
            goal_timeout=numbers["goal_timeout"],
        ),
        rotate_speed=numbers["rotate_speed"],
    )

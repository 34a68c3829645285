"""The interface of a dock adapter: from a request to a goal, from feedback to a stage, from a result to an outcome.

Messages are decoded JSON with the fields of the ROS message. An adapter validates only what the message's codec cannot.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.goal import GoalError, GoalStatus, Verb

Fields = Mapping[str, Any]

# The simple request's two fields, which every type takes or refuses.
DOCK_ID, DESIRED = "dock_id", "desired_battery_state"
# A dock without a name: its pose and its type, and whether the name or the pose counts.
POSE, TYPE, USE_ID = "dock_pose", "dock_type", "use_dock_id"
# sensor_msgs/BatteryState.power_supply_status: what a docked robot's battery may do, and that of an undocked one.
DOCKED = {0: "UNKNOWN", 1: "CHARGING", 4: "FULL"}
UNDOCKED = {0: "UNKNOWN", 2: "DISCHARGING", 3: "NOT_CHARGING"}
# The code of an aborted goal without a reason.
NO_REASON = "goal_aborted"


class Progress(NamedTuple):
    """The facts in a feedback message; None for those that it lacks."""

    stage: str | None = None
    retries: int | None = None


@dataclass(frozen=True)
class Outcome:
    """The end of a goal: its state, the reason if it failed, and the number of retries if the result has it."""

    status: GoalStatus
    error: GoalError | None = None
    retries: int | None = None


@dataclass(frozen=True)
class DockAdapter:
    """A type of docking action about which nothing is known: its goals are sent in the message's own fields.

    Attributes:
        verb: Whether its goals dock or undock.
        family: The package that defines the type: the docking and the undocking action of a family belong together.
        action_type: The type; empty for any other type.
        action_name: The name under which its servers offer it, without a namespace.
        takes: The fields of a request that the goal message does not have, and `goal` takes: a `desired_battery_state`,
            a `dock_pose` (geometry_msgs/PoseStamped), names.
        tells_stage: Whether `progress` has to be asked about feedback.
    """

    verb: Verb
    family: str = ""
    action_type: str = ""
    action_name: str = ""
    takes: tuple[str, ...] = ()
    tells_stage: bool = False

    @property
    def default(self) -> Fields | None:
        """The request that an empty body stands for; None if a body is required."""
        return {} if self.action_type else None

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Return the fields of the goal message for a request.

        Args:
            request: A simple request, the goal message's own fields, or both. A
                `desired_battery_state` and a `dock_pose` that it takes are complete and valid.
            default_dock: The dock to use if the request names none; empty: none.
            path: Where the request was, for errors.

        Raises:
            InvalidField: The type cannot take such a request.
        """
        return request

    def dock_of(self, goal: Fields) -> str | None:
        """Return the name of the dock that a goal message is for; empty: the server chooses; None: it has no name."""
        return None

    def at_dock(self, goal: Fields, dock: str) -> Fields:
        """Return a goal message without the name of a dock for a dock by its name."""
        return goal

    def progress(self, feedback: Fields) -> Progress:
        """Return the stage and the number of retries that feedback tells."""
        return Progress()

    def outcome(self, status: GoalStatus, result: Fields) -> Outcome:
        """Return how a goal ended.

        Args:
            status: How it ended according to ROS: succeeded, canceled or aborted.
            result: The result.
        """
        return Outcome(status)


def invalid(path: str, name: str, expected: str, detail: str) -> InvalidField:
    """Return the error for one field of a request."""
    return InvalidField([FieldError(f"{path}.{name}" if path else name, expected, detail)])


def read_dock_id(request: Fields, path: str) -> str:
    """Return the dock that a request names; empty if it names none.

    Raises:
        InvalidField: It is not a name.
    """
    dock = request.get(DOCK_ID)
    if dock is None and DOCK_ID not in request:
        return ""
    if not isinstance(dock, str) or not dock.strip():
        raise invalid(path, DOCK_ID, "the name of a dock", got(dock))
    return dock


def named_dock(request: object) -> str:
    """Return the dock that counts of those in a request, by its `dock_id`; empty if there is none."""
    if not isinstance(request, Mapping) or not isinstance(dock := request.get(DOCK_ID), str):
        return ""
    return dock if request.get(USE_ID, POSE not in request) is True else ""


def choose_dock(request: Fields, location: object, path: str) -> str:
    """Return the dock that a request names with `dock_id` or `desired_battery_state.location`; empty if with neither.

    Raises:
        InvalidField: The two differ, or the first is not a name.
    """
    dock = read_dock_id(request, path)
    if not isinstance(location, str) or not location:
        return dock
    if dock and dock != location:
        raise invalid(path, f"{DESIRED}.location", f"the same dock as {DOCK_ID}", got(location))
    return location


def take_battery(request: Fields, allowed: Mapping[int, str], path: str) -> tuple[dict[str, Any], Fields]:
    """Split a request into the fields of the goal message and the desired battery state, which it does not have.

    Raises:
        InvalidField: The action cannot bring about such a state.
    """
    fields = dict(request)
    battery: Fields = fields.pop(DESIRED, {})
    status = battery.get("power_supply_status", 0)
    if status not in allowed:
        expected = ", ".join(f"{number} ({name})" for number, name in allowed.items())
        raise invalid(path, f"{DESIRED}.power_supply_status", f"one of {expected}", got(status))
    return fields, battery


def refuse(request: Fields, names: Collection[str], why: str, path: str) -> None:
    """Refuse a request that has one of these fields.

    Raises:
        InvalidField: It has.
    """
    for name in names:
        if name in request:
            raise invalid(path, name, f"no {name}: {why}", got(request[name]))

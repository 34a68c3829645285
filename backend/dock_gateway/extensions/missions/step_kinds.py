"""What a step of a mission may be, as clients send it."""

import math
from datetime import datetime, timedelta
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, Strict, WithJsonSchema, model_validator

from dock_gateway.http.bodies import Slug, expected
from dock_gateway.http.queries import TIME_PATTERN, Time
from dock_gateway.http.schema import RosName, Schema
from dock_gateway.setting_types import LONGEST_NAME, TOPIC

# The longest that a step may take or wait, in seconds: a week.
LONGEST = 604_800.0
MAX_POSES = 100


def _absolute(example: str) -> AfterValidator:
    def check(name: str) -> str:
        if len(name) > LONGEST_NAME or not name.startswith("/") or not TOPIC.fullmatch(name):
            raise expected(f"an absolute name, such as {example}")
        return name

    return AfterValidator(check)


_ABSOLUTE = WithJsonSchema({"type": "string", "maxLength": LONGEST_NAME, "pattern": f"^(?=/){TOPIC.pattern}$"})
ActionName = Annotated[RosName, _absolute("/fibonacci"), _ABSOLUTE]
ServiceName = Annotated[RosName, _absolute("/reset"), _ABSOLUTE]
TopicName = Annotated[RosName, _absolute("/light"), _ABSOLUTE]
TypeName = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
Request = Annotated[dict[str, Any], Field(description="As the body of `POST /dock` and `POST /undock`")]
Metres = Annotated[float, Field(ge=-1e6, le=1e6)]


class ActionStep(Schema):
    """A goal of any action. `goal` has the fields of the message; those left out have their defaults."""

    name: ActionName
    goal: Annotated[dict[str, Any], Field(default_factory=dict)]


class Waypoint(Schema):
    """Where to drive, in metres in a frame, and how to stand there: `yaw`, in radians."""

    x: Metres
    y: Metres
    yaw: Annotated[float, Field(ge=-10, le=10)] = 0.0
    frame: Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)] = "map"

    def stamped(self) -> dict[str, Any]:
        """Return it as a `geometry_msgs/msg/PoseStamped`."""
        return {
            "header": {"frame_id": self.frame},
            "pose": {
                "position": {"x": self.x, "y": self.y},
                "orientation": {"z": math.sin(self.yaw / 2), "w": math.cos(self.yaw / 2)},
            },
        }


class NavigateStep(Schema):
    """Where nav2 drives the robot: to a `place` by its id, to a `pose`, or through `poses` to the last one."""

    place: Slug | None = None
    pose: Waypoint | None = None
    poses: Annotated[list[Waypoint], Field(min_length=1, max_length=MAX_POSES)] | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        require_one(self, "place", "pose", "poses")
        return self

    @property
    def action(self) -> str:
        """The name of its action in the namespace of its robot."""
        return "navigate_through_poses" if self.poses is not None else "navigate_to_pose"

    def goal(self, place: Waypoint | None = None) -> dict[str, Any]:
        """Return it as a goal of its action; `place` is where its place is, if it has one."""
        pose = self.pose or place
        if pose is not None:
            return {"pose": pose.stamped()}
        return {"poses": [pose.stamped() for pose in self.poses or ()]}


class CallStep(Schema):
    """A call of a service that `allow_services` names. Its response is not kept.

    `request` has the fields of the message; those left out have their defaults. `type` is needed if it has several.
    """

    service: ServiceName
    request: Annotated[dict[str, Any], Field(default_factory=dict)]
    type: TypeName | None = None


class PublishStep(Schema):
    """One message on a topic that `allow_publish` names.

    `message` has its fields; those left out have their defaults. `type` is needed if no one is on the topic.
    """

    topic: TopicName
    message: Annotated[dict[str, Any], Field(default_factory=dict)]
    type: TypeName | None = None


class NotifyStep(Schema):
    """A sentence for people: an alert of the robot, which webhooks get, too. A `critical` one needs somebody to act."""

    text: Annotated[str, Field(min_length=1, max_length=300, pattern=r"\S")]
    critical: bool = False


class WaitStep(Schema):
    """One thing to wait for.

    `seconds`; a time, `until`; a charge of the battery (0 to 1), `battery`; or `person`: until a person continues the
    mission.
    """

    seconds: Annotated[float, Field(ge=0, le=LONGEST)] | None = None
    until: Annotated[Time, Strict(False), Field(json_schema_extra=TIME_PATTERN)] | None = None
    battery: Annotated[float, Field(gt=0, le=1)] | None = None
    person: bool = False

    def ends_at(self, started_at: datetime) -> datetime | None:
        """Return when it is over, if it began then; None if a charge or a person ends it."""
        return self.until if self.seconds is None else started_at + timedelta(seconds=self.seconds)

    @model_validator(mode="after")
    def _has_one_end(self) -> Self:
        require_one(self, "seconds", "until", "battery", "person")
        return self


def require_one(fields: Schema, *names: str) -> None:
    """Refuse what has not exactly one of some fields.

    Raises:
        PydanticCustomError: It has none, or several.
    """
    found = [name for name in names if getattr(fields, name) is not None and getattr(fields, name) is not False]
    if len(found) != 1:
        choice = f"{', '.join(names[:-1])} and {names[-1]}"
        raise expected(f"one of {choice}", f"got {' and '.join(found) or 'none'}")

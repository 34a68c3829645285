"""A shared dock: what clients send, and what is stored. A new field is declared here alone."""

from datetime import datetime
from typing import Annotated

from pydantic import ConfigDict, Field, JsonValue

from dock_gateway.core.event import utc_now
from dock_gateway.core.scene import FARTHEST
from dock_gateway.http.bodies import Name60, RobotName
from dock_gateway.http.schema import RobotSelection, Schema

MAX_GOALS = 10
MAX_WAITING_PLACES = 20

DOCK_EXAMPLE: JsonValue = {
    "robots": {"all": False, "names": ["/robot1", "/robot2"], "groups": ["hall 1"]},
    "pose": {"frame": "map", "x": 1.0, "y": 2.5, "theta": 0.0},
    "type": "wall_dock",
    "by": "Ada",
}


class DockPose(Schema):
    """Where a dock is, or a robot waits for one: metres and radians in a frame."""

    frame: Name60 = "map"
    x: Annotated[float, Field(ge=-FARTHEST, le=FARTHEST, description="Metres")]
    y: Annotated[float, Field(ge=-FARTHEST, le=FARTHEST, description="Metres")]
    theta: Annotated[float, Field(ge=-7, le=7, description="Radians")] = 0.0


class DockFields(Schema):
    """The fields of a shared dock."""

    robots: Annotated[RobotSelection, Field(description="The robots that it fits; all by default")] = RobotSelection(
        all=True
    )
    pose: Annotated[DockPose | None, Field(description="Where the docked robot stands, if that is known")] = None
    type: Annotated[Name60 | None, Field(description="Its type at the docking servers: one of `dock_plugins`")] = None
    waiting_places: Annotated[
        list[DockPose],
        Field(
            default_factory=list,
            max_length=MAX_WAITING_PLACES,
            description="Where robots on missions wait for it, one at each",
        ),
    ]


class DockEntry(DockFields):
    """A shared dock as it is stored: who changed it last, if known, and when."""

    changed_by: str | None
    changed_at: datetime


class DockBody(DockFields):
    """A shared dock that is stored. `by` is who changes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [DOCK_EXAMPLE]})

    by: Name60 | None = None

    def entry(self) -> DockEntry:
        """Return the dock, changed now."""
        fields = {name: getattr(self, name) for name in DockFields.model_fields}
        return DockEntry(**fields, changed_by=self.by, changed_at=utc_now())


class Hold(Schema):
    """Who has a dock.

    Attributes:
        robot: The namespace of the robot; None: one without a gateway stands there.
        standing: Whether it stands there; else the dock is reserved for it.
        goal_ids: The docking goals of the robot to this dock that may run.
        since_at: When it was reserved or, if the robot stands there, since when it does.
        asked_at: When the last of its goals asked for the dock.
        by: The person who said so, if one did.
    """

    model_config = ConfigDict(frozen=True)

    robot: RobotName | None
    standing: bool = False
    goal_ids: tuple[str, ...] = ()
    since_at: datetime
    asked_at: datetime | None = None
    by: str | None = None


class DockRecord(Schema):
    """What has happened at a dock.

    Attributes:
        hold: Who has it; None: nobody.
        failures: Number of dockings in a row that have failed.
        out_of_order_at: Since when it is out of order; None: it is not.
        note: Why it is, if that is known.
        cleared_at: When a person last said that nobody stands there: no earlier docking counts.
    """

    model_config = ConfigDict(frozen=True)

    hold: Hold | None = None
    failures: int = 0
    out_of_order_at: datetime | None = None
    note: str | None = None
    cleared_at: datetime | None = None


class WaitEntry(Schema):
    """A robot that waits for a dock.

    Attributes:
        docks: Those that it would take.
        since_at: Since when it waits.
        asked_at: When it last asked.
        battery: Its charge then, 0 to 1; None if that is unknown.
        wait_at: Where it waits, or is driving to; None: where it is.
        arrives_by: Until when it may be driving there, without asking; None: it has asked since.
    """

    model_config = ConfigDict(frozen=True)

    docks: tuple[str, ...]
    since_at: datetime
    asked_at: datetime
    battery: float | None = None
    wait_at: DockPose | None = None
    arrives_by: datetime | None = None

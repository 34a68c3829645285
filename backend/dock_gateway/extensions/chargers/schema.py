"""What the API returns about shared docks, and what people say of them."""

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from dock_gateway.extensions.chargers.dock import DockEntry, DockPose
from dock_gateway.http.bodies import Name60, RobotName, expected
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Schema
from dock_gateway.streams.schema import FleetEvent


class DockState(StrEnum):
    """What is the matter with a shared dock."""

    FREE = "free"
    RESERVED = "reserved"
    OCCUPIED = "occupied"
    OCCUPIED_BY_UNKNOWN = "occupied_by_unknown"
    NO_CONTACT = "no_contact"
    OUT_OF_ORDER = "out_of_order"


class DockWait(Schema):
    """A robot that waits for a dock; `battery` is its charge, 0 to 1, if that is known.

    `wait_at` is where it waits, or is driving to; null: where it is.
    """

    robot: str
    since_at: datetime
    battery: float | None
    wait_at: DockPose | None


class SharedDock(DockEntry, Versioned):
    """A shared dock. `detail` says in a sentence what its `state` means.

    `robot` has it, since `since_at`, for its goals `goal_ids`; null if nobody has it, or the login does not see the
    robot. `failures` counts the dockings in a row that have failed. `waiting` lists the robots that wait, the first
    first.
    """

    dock_id: str
    state: DockState
    detail: str
    robot: str | None
    since_at: datetime | None
    goal_ids: list[str]
    out_of_order_at: datetime | None
    note: str | None
    failures: int
    waiting: list[DockWait]


class SharedDockList(Schema):
    """The shared docks, by name."""

    shared_docks: list[SharedDock]


class DockReport(Schema):
    """What a person has seen at a dock: only the fields that are there count.

    `occupied_by` is `nobody`, `unknown` (a robot without a gateway), or a robot. A dock that is no longer out of order
    counts failures from 0.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [{"occupied_by": "nobody", "by": "Ada"}]})

    occupied_by: Literal["nobody", "unknown"] | RobotName | None = None
    out_of_order: bool | None = None
    note: Annotated[Name60 | None, Field(description="Why it is out of order")] = None
    by: Name60 | None = None

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.occupied_by is None and self.out_of_order is None:
            raise expected("`occupied_by` or `out_of_order`", "got neither", path="occupied_by")
        if self.note is not None and not self.out_of_order:
            raise expected("no note, unless `out_of_order` is true", path="note")
        return self


class SharedDockEvent(FleetEvent):
    """A shared dock has changed, or is removed: then `shared_dock` is null."""

    type: Literal["shared_dock"]
    time: datetime
    dock_id: str
    shared_dock: SharedDock | None


# What streams can ask for.
EVENTS = (SharedDockEvent,)

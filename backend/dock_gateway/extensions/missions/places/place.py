"""A place: what clients send and get, and what is stored."""

from datetime import datetime

from pydantic import ConfigDict, JsonValue

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.http.bodies import Name60
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Schema

EXAMPLE: JsonValue = {"name": "Shelf A3", "x": 4.2, "y": 1.5, "yaw": 1.57, "by": "Ada"}


class PlaceFields(Waypoint):
    """The fields of a place: a pose, and a `name` to show instead of its id."""

    name: Name60 | None = None


class PlaceEntry(PlaceFields):
    """A place as it is stored: who changed it last, if known, and when."""

    changed_by: str | None
    changed_at: datetime

    @property
    def pose(self) -> Waypoint:
        """The pose."""
        return Waypoint(**{name: getattr(self, name) for name in Waypoint.model_fields})


class PlaceBody(PlaceFields):
    """A place that is stored. `by` is who changes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    by: Name60 | None = None

    def entry(self) -> PlaceEntry:
        """Return the place, changed now."""
        fields = {name: getattr(self, name) for name in PlaceFields.model_fields}
        return PlaceEntry(**fields, changed_by=self.by, changed_at=utc_now())


class Place(PlaceEntry, Versioned):
    """A place that missions drive to, by its id: `{"navigate": {"place": "shelf-a3"}}`."""

    id: str


class PlaceList(Schema):
    """The places, by id."""

    places: list[Place]

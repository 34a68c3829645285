"""Documents of a site as those of the hub: names get the site in front. Plain data in, plain data out.

The models of the documents say which fields there are, and which of them are names of the ROS graph. A field that an
older site lacks is null; one that only a newer site knows is left out.
"""

from collections.abc import Sequence
from inspect import isclass
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel

from dock_gateway.core.goal import GoalStatus
from dock_gateway.fleet.schema import Alert, Robot
from dock_gateway.goals.approval_schema import Approval
from dock_gateway.goals.schema import GoalState
from dock_gateway.http.schema import OnGraph
from dock_gateway.stop.schema import StopState
from dock_hub import fields
from dock_hub.fields import Document, Reader

# The fields that are neither names nor taken over as they are: what the hub relies on is checked.
READERS: dict[type[BaseModel], dict[str, Reader]] = {
    Robot: {
        "battery_topic": fields.maybe(fields.name),
        "default": fields.no,  # a gateway is set up for one robot, the hub for none
        "join": fields.nothing,  # settings of the site
        "display_name": fields.maybe(fields.text),
        "groups": fields.each(fields.text),
    },
    StopState: {"latched": fields.flag},
    GoalState: {
        "goal_id": fields.text,
        "status": fields.one_of(*GoalStatus),
        "last_event_id": fields.nothing,  # an id of the site
    },
    Alert: {
        "id": fields.site_id,
        "etag": fields.text,
        "kind": fields.text,
        "robot": fields.whole_site,
        "severity": fields.one_of("critical", "warning"),
    },
    Approval: {"id": fields.site_id},
}


def readers_of(model: type[BaseModel]) -> dict[str, Reader]:
    """Return the readers of all fields of a model: those given, or what their types say."""
    given = READERS.get(model, {})
    return {
        name: given.get(name) or _reader(field.annotation, field.metadata) or fields.as_is
        for name, field in model.model_fields.items()
    }


def _reader(annotation: Any, marks: Sequence[Any] = ()) -> Reader | None:
    """Return the reader of a type that has names in it; None if it has none."""
    if any(isinstance(mark, OnGraph) for mark in marks):
        return fields.name
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _reader(parts[0], parts[1:])
    if origin in (list, Union, UnionType):
        found = next(filter(None, map(_reader, parts)), None)
        return found and (fields.each(found) if origin is list else fields.maybe(found))
    if isclass(annotation) and issubclass(annotation, BaseModel):
        inner = readers_of(annotation)
        return None if set(inner.values()) <= {fields.as_is} else fields.shape(inner)
    return None


_ROBOT = fields.shape(readers_of(Robot), site_field=True)
_ALERT = fields.shape(readers_of(Alert), site_field=True)
_APPROVAL = fields.shape(readers_of(Approval), site_field=True)


def read_robots(site: str, robots: Any) -> list[Document]:
    """Return robots of a site as those of the hub, without what only makes sense at the site.

    Raises:
        ForeignDocumentError: They are not robots.
    """
    return fields.each(_ROBOT)(site, robots)


def read_names(site: str, names: Any) -> list[str]:
    """Return the names of robots of a site as those of the hub.

    Raises:
        ForeignDocumentError: They are not names.
    """
    return fields.each(fields.name)(site, names)


def read_alerts(site: str, alerts: Any) -> list[Document]:
    """Return alerts of a site as those of the hub. One about no robot is about the site.

    Raises:
        ForeignDocumentError: They are not alerts.
    """
    return fields.each(_ALERT)(site, alerts)


def read_approvals(site: str, approvals: Any) -> list[Document]:
    """Return the goals of agents that wait at a site for a person as those of the hub.

    Raises:
        ForeignDocumentError: They are not approvals.
    """
    return fields.each(_APPROVAL)(site, approvals)

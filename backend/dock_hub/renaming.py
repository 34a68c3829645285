"""Documents of a site as those of the hub: names get the site in front. Plain data in, plain data out.

What a site sends is read by explicit lists of fields: the hub shows nothing of a site that is not on them. A field that
an older site lacks is null; one that only a newer site knows is left out.
"""

from typing import Any

from dock_gateway.core.goal import GoalStatus
from dock_hub import fields
from dock_hub.fields import Document

_SERVER = fields.shape(
    {"action_name": fields.name, **fields.copied("action_type", "available", "answering", "duplicate")}
)
_GOAL_STATE = fields.shape(
    {
        "goal_id": fields.text,
        "action_name": fields.name,
        "status": fields.one_of(*GoalStatus),
        "last_event_id": fields.nothing,  # an id of the site
        **fields.copied("action_type", "verb", "stalled", "origin", "stage", "retries", "error"),
        **fields.copied("created_at", "updated_at", "finished_at", "feedback_count"),
    }
)
_STOP = fields.shape(
    {"latched": fields.flag, "robots": fields.each(fields.name), **fields.copied("since", "by", "persisted")}
)
_ROBOT = fields.shape(
    {
        "name": fields.name,
        "default": fields.no,  # a gateway is set up for one robot, the hub for none
        "battery_topic": fields.maybe(fields.name),
        "stop": _STOP,
        "dock": fields.maybe(_SERVER),
        "undock": fields.maybe(_SERVER),
        "join": fields.nothing,  # settings of the site
        "goals": fields.each(_GOAL_STATE),
        "last_goal": fields.maybe(_GOAL_STATE),
        "display_name": fields.maybe(fields.text),
        "groups": fields.each(fields.text),
        **fields.copied("docked", "charging", "simulated", "battery", "battery_publisher"),
    },
    site_field=True,
)
_ALERT = fields.shape(
    {
        "id": fields.site_id,
        "kind": fields.text,
        "robot": fields.whole_site,
        "severity": fields.one_of("critical", "warning"),
        **fields.copied("since", "title", "detail", "goal_id", "acknowledged"),
    },
    site_field=True,
)
_APPROVAL = fields.shape(
    {
        "approval_id": fields.site_id,
        "robot": fields.name,
        "action_name": fields.name,
        **fields.copied("agent", "client", "verb", "goal", "requested_at", "expires_at"),
    },
    site_field=True,
)


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

"""The JSON shapes of a hub: its sites, and the documents of gateways with names of the hub."""

from datetime import datetime
from importlib import import_module
from typing import Literal

from pydantic import BaseModel, ConfigDict

from dock_gateway.extension_list import modules_of
from dock_gateway.fleet.schema import Alert, Robot
from dock_gateway.goals.approval_schema import Approval
from dock_gateway.http.schema import Schema
from dock_gateway.observability.schema import Health, Readiness
from dock_gateway.streams.includes import type_of
from dock_gateway.streams.schema import UNASKED, FleetEvent, SnapshotEvent
from dock_hub.directory import SiteState
from dock_hub.stop_schema import PendingStop

_OF_EXTENSIONS = [import_module(name) for name in modules_of("schema")]
# The fields that extensions of a gateway add to goals, and that are null at a hub.
GOAL_FIELDS: dict[str, type[BaseModel]] = {}
for _each in _OF_EXTENSIONS:
    GOAL_FIELDS |= getattr(_each, "GOAL_FIELDS", {})
# The types of their events: they can be asked for, and there are no such events.
INCLUDES = tuple(type_of(event) for each in _OF_EXTENSIONS for event in getattr(each, "EVENTS", ()))


class SiteStop(Schema):
    """The robots of a site that a stop holds, and a stop of the hub that the site has not confirmed."""

    latched: bool
    robots: list[str]
    pending: PendingStop | None


class SiteInfo(Schema):
    """A site.

    `lag_ms` is the age of its newest report, `round_trip_ms` what a small answer took last. Its clock is
    `clock_offset_s` ahead of the hub's. `behind`: the hub still reads what it has missed, from the event `cursor` on.
    `refused` counts what was refused of this name, by code, and `detail` says why the last one was.
    """

    name: str
    state: SiteState
    changed_at: datetime
    version: str | None
    instance: str | None
    machine: str
    lag_ms: int | None
    round_trip_ms: float | None
    clock_offset_s: float | None
    cursor: str | None
    behind: bool
    robots: int
    goals_running: int
    alerts: int
    stop: SiteStop
    refused: dict[str, int]
    detail: str | None


class SiteList(Schema):
    """The sites, by name."""

    sites: list[SiteInfo]


class SiteRobot(Robot):
    """A robot of a site; its name has the site in front. If its site is not connected, it is as it was then."""

    site: str
    site_state: SiteState


class SiteRobotList(Schema):
    """The robots of all sites, by name."""

    robots: list[SiteRobot]


class SiteAlert(Alert):
    """An alert of a site, or of the hub itself about a site; `site` is null if it is about the hub."""

    site: str | None


class SiteAlertList(Schema):
    """The active alerts of all sites: critical ones first, then oldest first."""

    alerts: list[SiteAlert]


class SiteApproval(Approval):
    """An agent's goal at a site, which waits until a person allows it there."""

    site: str


class HubSnapshotEvent(SnapshotEvent):
    """The first message of a stream of a hub, with what `include` asks for.

    `stop` and `docking` are those of the robots of connected sites. A hub has no battery, no publisher and no
    simulator of its own.
    """

    model_config = ConfigDict(json_schema_serialization_defaults_required=False)

    robots: list[SiteRobot] = UNASKED  # type: ignore[assignment]
    alerts: list[SiteAlert] = UNASKED  # type: ignore[assignment]
    approvals: list[SiteApproval] = UNASKED  # type: ignore[assignment]
    sites: list[SiteInfo] = UNASKED


class HubRobotsEvent(FleetEvent):
    """The current state of robots that changed; `gone` names those that left."""

    type: Literal["robots"]
    time: datetime
    robots: list[SiteRobot]
    gone: list[str]


class HubAlertsEvent(FleetEvent):
    """The alerts changed. Contains all active alerts."""

    type: Literal["alerts"]
    time: datetime
    alerts: list[SiteAlert]


class HubApprovalsEvent(FleetEvent):
    """The goals of agents that wait for approval changed. Contains all that wait."""

    type: Literal["approvals"]
    time: datetime
    approvals: list[SiteApproval]


class SitesEvent(FleetEvent):
    """The sites changed. Contains all sites. Not sent if only ages and round trips have changed."""

    type: Literal["sites"]
    time: datetime
    sites: list[SiteInfo]


class HubHealth(Health):
    """Whether the hub itself works. `node` is empty and `hub` null: it is on no ROS graph, and has no hub."""

    broker_connected: bool


class HubReadiness(Readiness):
    """Whether the hub reaches its database and the NATS server, and how many sites are in which state.

    If a robot is named: whether its docking server is available and answers, too. `hint`, `settings` and `problems`
    are those of its site.
    """

    broker_connected: bool
    sites: dict[SiteState, int]

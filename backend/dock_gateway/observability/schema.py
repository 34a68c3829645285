"""The JSON shapes of `/healthz` and `/readyz`."""

from datetime import datetime
from enum import StrEnum
from typing import Literal

from dock_gateway.goals.action_schema import ActionServer
from dock_gateway.http.schema import Schema
from dock_gateway.stop.schema import StopState


class HubState(StrEnum):
    """Whether the hub reaches this site."""

    CONNECTED = "connected"
    REFUSED = "refused"
    UNREACHABLE = "unreachable"


class HubConnection(Schema):
    """Whether the hub of a site reaches it, and since when; `code` and `detail` say why it does not.

    `refused`: the hub does not take this site. `unreachable`: no answer of the hub, or no connection to the broker.
    """

    site: str
    state: HubState
    changed_at: datetime
    code: str | None
    detail: str | None


class Health(Schema):
    """Whether the gateway itself works; `node` is its name on the graph, `hub` is null without a hub."""

    status: Literal["ok", "ros_unavailable"]
    version: str
    node: str
    ros: dict[str, str]
    subscribers: int
    hub: HubConnection | None


class HistoryState(Schema):
    """The state of the history of goals and events.

    `waiting` (in memory) and `spooled` (on disk) count the entries that are not in the database yet; `dropped` counts
    the feedback and battery events that were discarded.
    """

    waiting: int
    spooled: int
    dropped: int
    database_reachable: bool
    last_error: str | None


class Readiness(Schema):
    """Whether the docking server of a robot is available and answers, with the state of the history and of the stop.

    `robot` is the robot. `robots` are all that were found on the graph, `hint` says what to do if this one has no
    docking server, `settings` are lines for that, and `problems` lists faults on the graph. They are empty for
    users with limits.
    """

    ready: bool
    robot: str
    robots: list[str]
    hint: str | None
    settings: list[str]
    problems: list[str]
    action_server: ActionServer
    undock_server: ActionServer
    history: HistoryState
    stop: StopState

"""The report of a stop: what it has done, and what failed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.grant import Grant

# The fields of a latch that say since when and by whom.
SINCE = ("stopped_at", "by")


@dataclass
class StopReport:
    """The result of a stop.

    Attributes:
        canceling: The goals that are being canceled.
        failed: The actions that refused or could not be reached, and the robots that are not known, to which zero
            velocity could not be published, or whose nodes do not get the stop.
        unconfirmed: The actions that have not answered the cancel request yet.
        stop: Which of the robots are stopped, as `GET /stop` shows it.
        stopped: The robots to which zero velocity was published, sorted.
        not_stopped: The other robots of this gateway, sorted: those that were not meant, and those that failed.
        others: The other gateways, where this one has a share of the robots and all of them were to stop.
        problems: Why more robots were stopped than were named, and why a restart of the gateway would forget the stop.
    """

    canceling: list[str] = field(default_factory=list)
    failed: list[dict[str, str | None]] = field(default_factory=list)
    unconfirmed: list[str] = field(default_factory=list)
    stop: dict[str, Any] = field(default_factory=dict)
    stopped: list[str] = field(default_factory=list)
    not_stopped: list[str] = field(default_factory=list)
    others: list[dict[str, Any]] = field(default_factory=list)
    problems: list[GatewayError] = field(default_factory=list)

    def document(self) -> dict[str, Any]:
        """Return what was done; without `problems`, which become a warning."""
        return {name: value for name, value in vars(self).items() if name != "problems"}

    def add(self, other: "StopReport") -> None:
        """Add what was done to other robots."""
        self.canceling += other.canceling
        self.failed += other.failed
        self.unconfirmed += other.unconfirmed
        self.stopped = sorted({*self.stopped, *other.stopped})


def not_stopped(robot: str, error: Exception) -> dict[str, str | None]:
    """Return the failure to publish zero velocity to a robot."""
    detail = f"zero velocity could not be published to {robot}: {error!r:.200}"
    return {"action_name": None, "robot": robot, "code": "publish_failed", "detail": detail}


def not_latched(robot: str, reason: str) -> dict[str, str | None]:
    """Return the failure to publish the stop on the topic of a robot."""
    detail = f"the stop could not be published on the topic of {robot}, so its nodes do not know of it: {reason}"
    return {"action_name": None, "robot": robot, "code": "latch_not_published", "detail": detail[:400]}


def not_known(robot: str, error: GatewayError) -> dict[str, str | None]:
    """Return the failure to find a robot."""
    return {"action_name": None, "robot": robot, "code": error.code, "detail": error.detail}


def not_canceled(action_name: str, error: BaseException) -> dict[str, str | None]:
    """Return the failure to cancel the goals of an action."""
    code, detail = GatewayError.code, "the gateway's log has the details"
    if isinstance(error, GatewayError):
        code, detail = error.code, error.detail
    return {"action_name": action_name, "robot": None, "code": code, "detail": detail}


def narrow_report(report: dict[str, Any], grant: Grant) -> dict[str, Any]:
    """Return a report with the robots of a grant only."""
    return report | {
        name: [robot for robot in report[name] if grant.covers_robot(robot)] for name in ("stopped", "not_stopped")
    }


def latched_stops(latch: dict[str, Any], of: Callable[[str], dict[str, Any]]) -> dict[str, Any]:
    """Return the latch of a namespace as `GET /stop` shows it, with the stop of each robot at or below it.

    Args:
        latch: The latch.
        of: Returns that of a robot.
    """
    stops = [{"robot": robot, **{name: of(robot)[name] for name in SINCE}} for robot in latch["robots"]]
    return _described(latch["latched"], [latch] if latch["latched"] else [], stops, persisted=latch["persisted"])


def together(states: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the stops of several namespaces as one: for all of them if for each."""
    stops = sorted((stop for state in states for stop in state["stops"]), key=itemgetter("robot"))
    first = [state for state in states if state["latched"]]
    for_all = bool(states) and all(state["for_all"] for state in states)
    return _described(for_all, first, stops, persisted=all(state["persisted"] for state in states))


def narrow_stops(state: dict[str, Any], grant: Grant) -> dict[str, Any]:
    """Return the stops of the robots of a grant; who has stopped all of them, too."""
    stops = [stop for stop in state["stops"] if grant.covers_robot(stop["robot"])]
    return _described(state["for_all"], [state] if state["for_all"] else [], stops, persisted=state["persisted"])


def _described(
    for_all: bool, wider: Sequence[dict[str, Any]], stops: list[dict[str, Any]], *, persisted: bool
) -> dict[str, Any]:
    """Return the document of some stops; `wider` are those of namespaces that hold, also where there is no robot."""
    first = min((*wider, *stops), key=lambda stop: str(stop["stopped_at"]), default=None)
    return {
        "latched": first is not None,
        "for_all": for_all,
        **(dict.fromkeys(SINCE) if first is None else {name: first[name] for name in SINCE}),
        "robots": [stop["robot"] for stop in stops],
        "stops": stops,
        "persisted": persisted,
    }

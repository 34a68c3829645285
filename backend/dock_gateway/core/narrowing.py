"""Narrows events about several robots to a reader's grant: each such event says how."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import orjson

from dock_gateway.core.event import Event
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant

Document = dict[str, Any]


def narrow(event: Event, grant: Grant) -> Event | None:
    """Return an event with what a grant covers; None if that is nothing.

    An event about several robots is encoded again for each reader whose grant is limited, and only for those.
    """
    if event.source is not None and not grant.shows(event.source):
        return None
    if event.narrow is None:
        return event
    shown = event.narrow(orjson.loads(event.data), grant)
    return None if shown is None else replace(event, data=encode(shown))


def narrow_robots(document: Document, grant: Grant) -> Document | None:
    """Return the robots that changed and those that are gone."""
    robots = [_narrow_robot(robot, grant) for robot in document["robots"] if grant.covers_robot(robot["name"])]
    gone = [*filter(grant.covers_robot, document["gone"])]
    return {**document, "robots": robots, "gone": gone} if robots or gone else None


def narrow_alerts(document: Document, grant: Grant) -> Document:
    """Return the alerts that remain."""
    return {**document, "alerts": [alert for alert in document["alerts"] if grant.covers_alert(alert["robot"])]}


def narrow_approvals(document: Document, grant: Grant) -> Document:
    """Return the goals that wait for approval."""
    waiting = [each for each in document["approvals"] if grant.covers_action(each["action_name"])]
    return {**document, "approvals": waiting}


def by_robot(kind: str) -> Callable[[Document, Grant], Document]:
    """Narrow what an event has of each robot, by robot, in the field `kind`: also by the topic that it came from."""

    def narrow_by_robot(document: Document, grant: Grant) -> Document:
        shown = {
            robot: each
            for robot, each in document[kind].items()
            if grant.covers_robot(robot) and ("topic" not in each or grant.shows(each["topic"]))
        }
        return {**document, kind: shown}

    return narrow_by_robot


def _narrow_robot(robot: Document, grant: Grant) -> Document:
    last = robot["last_goal"]
    return robot | {
        "join": None,  # it may name other robots
        "goals": [goal for goal in robot["goals"] if grant.covers_action(goal["action_name"])],
        "last_goal": last if last is not None and grant.covers_action(last["action_name"]) else None,
    }

"""What streams can be asked for: types of events, those of extensions too, and groups of them."""

from datetime import datetime
from typing import Literal

import pytest

from dock_gateway.core.errors import InvalidField
from dock_gateway.extension import extensions
from dock_gateway.http.schema import Schema
from dock_gateway.streams.includes import Includes, type_of
from dock_gateway.streams.schema import EVENTS, GOAL_EVENTS, FleetEvent

SYSTEM = {"battery_publisher", "action_server", "docking", "stop", "simulator"}


class Temperature(Schema):
    type: Literal["temperature"]
    time: datetime


class Mission(FleetEvent):
    type: Literal["mission"]
    time: datetime


@pytest.mark.parametrize(
    ("text", "types"),
    [
        ("", set()),
        (" battery , cmd_vel,,", {"battery", "cmd_vel"}),
        ("stop", {"stop"}),
        ("system", SYSTEM),
        ("robots", {"robots"}),
        ("fleet,stop", {"robots", "alerts", "approvals", "mission", "stop"}),
        ("temperature", {"temperature"}),
    ],
)
def test_names_are_types_of_events_and_groups(text: str, types: set[str]) -> None:
    assert Includes((Temperature, Mission)).read(text) == types


@pytest.mark.parametrize("name", ["everything", "status", "snapshot", "temperature"])
def test_what_is_sent_anyway_or_unknown_is_refused(name: str) -> None:
    with pytest.raises(InvalidField) as refused:
        Includes().read(f"battery,{name}")
    (error,) = refused.value.extra["errors"]
    assert (error["in"], error["path"], error["detail"]) == ("query", "include", f"got {name!r}")
    assert error["expected"].startswith("any of battery, cmd_vel")


def test_every_event_can_be_asked_for_by_its_type() -> None:
    events = (*EVENTS, *extensions().events)
    always = {type_of(model) for model in GOAL_EVENTS}
    names = Includes(extensions().events).names
    assert {type_of(model) for model in events} - always | {"system", "fleet"} == {*names}
    assert len(names) == len({*names})

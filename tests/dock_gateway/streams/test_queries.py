"""Queries of streams: what no robot and no goal can have is refused."""

import pytest

from dock_gateway.core.errors import InvalidField
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.streams.includes import Includes
from dock_gateway.streams.queries import read_event_filter


@pytest.mark.parametrize("action", ["", "/", "dock\0", "/robot 1/dock", "/robot1//dock", "dock/"])
async def test_what_is_no_name_of_an_action(action: str) -> None:
    parts = Parts({Settings: Settings(), Includes: Includes()})
    with pytest.raises(InvalidField) as refused:
        await read_event_filter(parts, {"action": action}, UNLIMITED)
    (error,) = refused.value.extra["errors"]
    assert (error["in"], error["path"], error["expected"]) == ("query", "action", "the name of an action")

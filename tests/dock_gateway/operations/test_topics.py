"""A topic is read by one function, whatever the door."""

import ast
from pathlib import Path
from typing import cast
from unittest.mock import AsyncMock, call

import dock_gateway
from dock_gateway.graph.relay import Outlet
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.operations.topics import ReadTopic, subscribe
from dock_gateway.settings import Settings
from tests.support.permits import acting, user

DOORS = [*Path(dock_gateway.__file__).parent.glob("extensions/*/subscriptions.py")]


async def test_a_topic_takes_a_place_and_is_read_until_it_is_closed() -> None:
    relays, quotas, ada = AsyncMock(Relays), Quotas(Settings()), user("ada")
    outlet = cast("Outlet", object())
    with acting(quotas, ada):
        reading = await subscribe(Parts({Relays: relays}), ada, ReadTopic("/scan", outlet, "std_msgs/msg/Bool"))
        assert relays.mock_calls == [call.join("/scan", "std_msgs/msg/Bool", outlet)]
        assert quotas.in_use == {"topics": 1}
        held: list[dict[str, int]] = []
        relays.leave.side_effect = lambda *_: held.append(quotas.in_use)
        await reading.aclose()
    assert relays.mock_calls[1:] == [call.leave("/scan", outlet)]
    assert held == [{"topics": 1}], "the place is held until the topic is left"
    assert quotas.in_use == {}


def test_no_door_reads_messages_in_a_way_of_its_own() -> None:
    for door in DOORS:
        tree = ast.parse(door.read_text())
        called = {
            node.func.attr
            for node in ast.walk(tree)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        }
        assert "join" not in called
        assert "leave" not in called

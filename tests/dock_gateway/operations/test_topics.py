"""A topic is read by one function, whatever the door."""

import ast
from contextlib import suppress
from pathlib import Path
from typing import cast
from unittest.mock import AsyncMock, call

import dock_gateway
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.graph.relay import Outlet
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Limit, Quotas
from dock_gateway.operations.topics import ReadTopic, subscribe
from dock_gateway.settings import Settings
from tests.support.permits import acting, user

DOORS = [*Path(dock_gateway.__file__).parent.glob("extensions/*/subscriptions.py")]


async def test_a_topic_takes_a_place_and_is_read_until_it_is_closed() -> None:
    relays, ada = AsyncMock(Relays), user("ada")
    quotas = Quotas(Settings(), {"topics": Limit("topics", 1, 1, 0)})

    def is_free() -> bool:
        with suppress(TooManyRequests), quotas.slot(ada, "topics"):
            return True
        return False

    outlet = cast("Outlet", object())
    with acting(quotas, ada):
        reading = await subscribe(Parts({Relays: relays}), ada, ReadTopic("/scan", outlet, "std_msgs/msg/Bool"))
        assert relays.mock_calls == [call.join("/scan", "std_msgs/msg/Bool", outlet)]
        assert not is_free()
        free: list[bool] = []
        relays.leave.side_effect = lambda *_: free.append(is_free())
        await reading.aclose()
    assert relays.mock_calls[1:] == [call.leave("/scan", outlet)]
    assert free == [False], "the place is held until the topic is left"
    assert is_free()


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

"""Who holds a robot. The graph is a fake; tests/system has a real one."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.ros import latch_port as module
from dock_gateway.ros.latch_port import LatchPort
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.typed_topics import GatewayEndpoints
from robot_io.qos import LISTEN
from robot_io.rclpy_private import Taken


@pytest.mark.parametrize("first", ["/e_stop", "/scanner"])
def test_the_one_that_holds_on_is_named_when_the_other_lets_go(monkeypatch: pytest.MonkeyPatch, first: str) -> None:
    def read_topic(_: object, topic: str) -> Any:
        qos = SimpleNamespace(durability="volatile")
        return SimpleNamespace(publishers=[SimpleNamespace(gid=topic.encode(), node=topic, qos=qos)])

    monkeypatch.setattr(module, "read_topic", read_topic)
    inbox = SimpleNamespace(put=lambda call, *args: call(*args))
    node = SimpleNamespace(create_publisher=lambda *_: None, subscribe=lambda *_: None)
    bridge: Any = SimpleNamespace(inbox=lambda: inbox, node=node)
    names: list[str | None] = []
    handlers: dict[str, Handler] = {}

    def join(topic: str, _: type, __: str, endpoints: GatewayEndpoints) -> None:
        handlers[topic] = next(handler for handler, quality in endpoints.handlers if quality is LISTEN)

    topics: Any = SimpleNamespace(bridge=bridge, join=join)
    LatchPort(topics, "/stop_latched", ["/e_stop", "/scanner"], on_latch=lambda *_: None, on_hold=names.append)

    def say(topic: str, number: int, *, latched: bool) -> None:
        handlers[topic](Taken(latched, number, 0, topic.encode()), None)

    say("/e_stop", 1, latched=True)
    say("/scanner", 1, latched=True)
    second = {"/e_stop": "/scanner", "/scanner": "/e_stop"}[first]
    say(first, 2, latched=False)
    assert names[-1] == second
    say(second, 2, latched=False)
    assert names[-1] is None

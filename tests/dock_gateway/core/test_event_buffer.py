"""The newest events are kept: so many, and so many bytes of them."""

import pytest

from dock_gateway.core import event_buffer
from dock_gateway.core.event import Event
from dock_gateway.core.event_buffer import EventBuffer


def event(number: int, size: int = 1) -> Event:
    return Event(b"x" * size, "goals", id=f"{number:03d}")


def test_by_number() -> None:
    buffer = EventBuffer(3)
    gone = [each.id for number in range(5) for each in buffer.put(event(number))]
    assert (gone, list(buffer)) == (["000", "001"], ["002", "003", "004"])
    assert buffer.put(event(2)) == []


def test_by_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(event_buffer, "MAX_BYTES", 100)
    buffer = EventBuffer(1000)
    for number in range(50):
        buffer.put(event(number, 30))
        assert sum(len(each.data) for each in buffer.values()) <= 100
    assert list(buffer) == ["047", "048", "049"]
    buffer.remove("048")
    buffer.remove("048")
    assert buffer.put(event(50, 30)) == []
    assert [each.id for each in buffer.put(event(51, 100))] == ["047", "049", "050"]
    buffer.put(event(52, 101))
    assert list(buffer) == [], "one that is too large alone is not kept"

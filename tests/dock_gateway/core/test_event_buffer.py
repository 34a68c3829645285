"""The newest events are kept: so many, and so many bytes of them."""

from dock_gateway.core.event import Event
from dock_gateway.core.event_buffer import MAX_BYTES, EventBuffer


def event(number: int, data: bytes = b"x") -> Event:
    return Event(data, "goals", id=f"{number:03d}")


def test_by_number() -> None:
    buffer = EventBuffer(3)
    gone = [each.id for number in range(5) for each in buffer.put(event(number))]
    assert (gone, list(buffer)) == (["000", "001"], ["002", "003", "004"])
    assert buffer.put(event(2)) == []


def test_by_bytes() -> None:
    buffer = EventBuffer(1000)
    third, whole, more = (bytes(size) for size in (MAX_BYTES * 3 // 10, MAX_BYTES, MAX_BYTES + 1))
    for number in range(50):
        buffer.put(event(number, third))
        assert sum(len(each.data) for each in buffer.values()) <= MAX_BYTES
    assert list(buffer) == ["047", "048", "049"]
    buffer.remove("048")
    buffer.remove("048")
    assert buffer.put(event(50, third)) == []
    assert [each.id for each in buffer.put(event(51, whole))] == ["047", "049", "050"]
    buffer.put(event(52, more))
    assert list(buffer) == [], "one that is too large alone is not kept"

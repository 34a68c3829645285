"""The ring: bounded in time and in bytes, whatever comes."""

from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.recordings.ring import LASTING, OVERHEAD, Ring
from robot_io.recording import Sample

SECONDS, BYTES = 30.0, 10_000


def sample(data: bytes = b"", topic: str = "/odom") -> Sample:
    return Sample(topic, "nav_msgs/msg/Odometry", data, 1, 2)


@given(st.lists(st.tuples(st.floats(0, 40), st.integers(0, 12_000), st.booleans()), max_size=60))
def test_its_limits_hold(messages: list[tuple[float, int, bool]]) -> None:
    now = 0.0
    ring = Ring(SECONDS, BYTES, lambda: now)
    times: dict[bytes, float] = {}
    for number, (pause, size, lasting) in enumerate(messages):
        now += pause
        data = number.to_bytes(4) + bytes(size)
        times[data] = now
        ring.put(sample(data), lasting=lasting)
        kept = ring.after(0)
        assert ring.size == sum(len(each.data) + OVERHEAD for each in kept) <= BYTES
        assert all(times[each.data] >= max(map(times.__getitem__, (e.data for e in kept))) - SECONDS for each in kept)
        assert [each.data for each in kept] == sorted(each.data for each in kept), "in the order in which they came"
        assert len(ring.lasting()) <= LASTING
        assert sum(len(each.data) for each in ring.lasting()) <= BYTES
    assert ring.heard == len(messages)


def test_what_is_new_since_a_mark() -> None:
    now = 0.0
    ring = Ring(SECONDS, BYTES, lambda: now)
    for number in range(10):
        now = float(number)
        ring.put(sample(bytes([number])))
    mark = ring.mark(3)
    assert [each.data[0] for each in ring.after(mark)] == [6, 7, 8, 9]
    assert ring.after(ring.heard) == []
    now = 100.0
    ring.put(sample(b"later"))
    assert [each.data for each in ring.after(mark)] == [b"later"]


def test_what_holds_outlasts_the_ring_and_repetitions_count_once() -> None:
    now = 0.0
    ring = Ring(SECONDS, BYTES, lambda: now)
    for data in (b"camera", b"laser", b"camera"):
        ring.put(sample(data, "/tf_static"), lasting=True)
    now = 1000.0
    ring.put(sample(b"odometry"))
    assert [each.data for each in ring.after(0)] == [b"odometry"]
    assert [each.data for each in ring.lasting()] == [b"laser", b"camera"]

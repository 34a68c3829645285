"""The ring: bounded in time and in bytes, whatever comes."""

from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.extensions.recordings.ring import OVERHEAD, Ring
from robot_io.recording import Sample

SECONDS, BYTES = 30.0, 10_000


def sample(data: bytes = b"", topic: str = "/odom") -> Sample:
    return Sample(topic, "nav_msgs/msg/Odometry", data, 1, 2)


@given(st.lists(st.tuples(st.floats(0, 40), st.integers(0, 12_000), st.integers(0, 3)), max_size=60))
def test_its_limits_hold(messages: list[tuple[float, int, int]]) -> None:
    now = 0.0
    ring = Ring(SECONDS, BYTES, lambda: now)
    times: dict[bytes, float] = {}
    for number, (pause, size, kept) in enumerate(messages):
        now += pause
        data = number.to_bytes(4) + bytes(size)
        times[data] = now
        ring.put(sample(data, f"/topic{kept}"), kept=kept)
        there = ring.after(0)
        assert ring.size == sum(len(each.data) + OVERHEAD for each in there) <= BYTES
        assert all(times[each.data] >= max(map(times.__getitem__, (e.data for e in there))) - SECONDS for each in there)
        assert [each.data for each in there] == sorted(each.data for each in there), "in the order in which they came"
        assert sum(len(each.data) for each in ring.held(0)) <= BYTES
    assert ring.heard == len(messages)


@given(
    st.lists(st.tuples(st.floats(0, 20), st.sampled_from("abc"), st.sampled_from(["/map", "/tf_static", "/odom"]))),
    st.floats(0, 60),
)
def test_at_each_moment_it_knows_what_a_new_subscriber_would_get(
    messages: list[tuple[float, str, str]], ago: float
) -> None:
    """However old the messages are: the newest of each latched topic, each once, and none of what came later."""
    keeps = {"/map": 1, "/tf_static": 2, "/odom": 0}
    now = 0.0
    ring = Ring(SECONDS, 1_000_000, lambda: now)
    for pause, text, topic in messages:
        now += pause
        ring.put(sample(text.encode(), topic), kept=keeps[topic])
    mark = ring.mark(min(ago, SECONDS))
    expected = {
        topic: list(dict.fromkeys(text for _, text, of in reversed(messages[:mark]) if of == topic))[:kept][::-1]
        for topic, kept in keeps.items()
    }
    found: dict[str, list[str]] = {topic: [] for topic in keeps}
    for each in ring.held(mark):
        found[each.topic].append(each.data.decode())
    assert found == expected


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


def test_a_large_map_leaves_room_for_what_other_topics_hold() -> None:
    now = 0.0
    ring = Ring(SECONDS, BYTES, lambda: now)
    ring.put(sample(b"laser", "/tf_static"), kept=50)
    for number in range(3):
        now += 1000.0
        ring.put(sample(bytes([number]) * 6_000, "/map"), kept=2)
    now += 1000.0
    ring.put(sample(b"odometry"))
    assert [each.data[:5] for each in ring.held(0)] == [b"laser", bytes([2]) * 5]

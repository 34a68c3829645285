"""What a client sends has a bound as a whole, not for each of its arrays alone; what is long is read in turn."""

import threading
from array import array
from functools import partial
from typing import Any

import orjson
import pytest
from geometry_msgs.msg import PoseArray, PoseStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import Image, LaserScan, PointCloud2, PointField
from std_msgs.msg import Header
from test_msgs.message_fixtures import get_test_msg
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from dock_gateway.core.errors import InvalidField, MalformedRequest
from dock_gateway.ros.messages import cdr
from dock_gateway.ros.messages import codec as message_codec
from dock_gateway.ros.messages.bounds import FEW_NESTED, MAX_NESTED, is_long, most_nested
from dock_gateway.ros.messages.cdr import from_cdr, to_cdr
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.types import Nested, Sequence, kinds
from dock_gateway.ros.messages.wire import count_nested
from tests.support.waiting import PATIENCE

A_FEW = 100


def count(message: Any) -> int:
    """How many messages a message consists of, itself and its texts in arrays included."""
    total = 1
    for name, kind in kinds(type(message)).items():
        value = getattr(message, name)
        if isinstance(kind, Nested):
            total += count(value)
        elif isinstance(kind, Sequence) and kind.code is None:
            total += sum(count(item) if isinstance(kind.item, Nested) else 1 for item in value)
    return total


few = st.integers(0, 12)
markers = st.lists(
    st.fixed_dictionaries({"points": few.map(lambda n: [{}] * n), "colors": few.map(lambda n: [{}] * n)}), max_size=8
)
trajectories = st.tuples(few, few).map(lambda n: {"joint_names": ["joint"] * n[0], "points": [{}] * n[1]})
values = st.one_of(
    st.tuples(st.just(MarkerArray), markers.map(lambda each: {"markers": each})),
    st.tuples(st.just(Path), few.map(lambda n: {"poses": [{}] * n * 3})),
    st.tuples(st.just(PoseArray), few.map(lambda n: {"poses": [{}] * n * 5})),
    st.tuples(st.just(JointTrajectory), trajectories),
)


@given(values)
def test_no_message_holds_more_than_the_bound_however_it_is_nested(case: tuple[Any, Any]) -> None:
    message_class, value = case
    whole = codec(message_class).parse(value)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(message_codec, "MAX_NESTED", A_FEW)
        if count(whole) > A_FEW:
            with pytest.raises(InvalidField, match=f"at most {A_FEW} nested messages"):
                codec(message_class).parse(value)
        else:
            assert codec(message_class).parse(value) == whole


@given(values)
def test_a_message_in_bytes_holds_no_more_than_its_size_allows(case: tuple[Any, Any]) -> None:
    message = codec(case[0]).parse(case[1])
    data = to_cdr(message)
    assert count(message) <= most_nested(case[0], len(data))
    assert from_cdr(data, case[0]) == message


@given(values)
def test_a_message_in_bytes_is_counted_to_its_end(case: tuple[Any, Any]) -> None:
    message = codec(case[0]).parse(case[1])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cdr, "MAX_NESTED", 0)  # whatever its size
        patch.setattr(cdr, "count_nested", partial(count_nested, most=A_FEW))
        if count(message) > A_FEW:
            with pytest.raises(MalformedRequest, match="nested"):
                from_cdr(to_cdr(message), case[0])
        else:
            assert from_cdr(to_cdr(message), case[0]) == message


@pytest.mark.parametrize("poses", [1_600, 1_700, 10_000])
def test_many_nested_messages_in_bytes_are_refused_before_they_are_decoded(
    monkeypatch: pytest.MonkeyPatch, poses: int
) -> None:
    data = to_cdr(Path())[:-4] + poses.to_bytes(4, "little") + bytes(72 * poses)
    if poses == 1_600:
        assert len(from_cdr(data, Path).poses) == poses
    else:
        monkeypatch.setattr(cdr, "deserialize_message", None)
        with pytest.raises(MalformedRequest, match="hold more than 10,000 nested"):
            from_cdr(data, Path)


@pytest.mark.parametrize(
    "message",
    [
        Image(encoding="rgb8", data=bytes(900_000)),
        OccupancyGrid(data=array("b", bytes(4_000_000))),
        PointCloud2(
            fields=[PointField(name=name, datatype=7, count=1) for name in "xyz"], data=bytes(3_000_001), is_dense=True
        ),
        LaserScan(ranges=array("f", range(100_000)), intensities=array("f", range(100_000))),
        Path(poses=[PoseStamped(header=Header(frame_id="m" * 300))] * 1_000),
    ],
    ids=lambda message: type(message).__name__,
)
def test_what_is_large_without_many_nested_messages_is_read(message: Any) -> None:
    assert from_cdr(to_cdr(message), type(message)) == message


@pytest.mark.parametrize(
    "data", [b"\0\1\0\0", b"\0\3\0\0" + bytes(200_000), b"\0\1\0\0" + b"\1" * 200_000, b"\0\0\0\0" + b"\xff" * 200_000]
)
def test_bytes_that_are_no_message_are_refused(data: bytes) -> None:
    with pytest.raises(MalformedRequest):
        from_cdr(data, PointCloud2)


@pytest.mark.parametrize("name", ["Arrays", "BoundedSequences", "UnboundedSequences"])
def test_values_in_bytes_are_where_ros_puts_them(name: str) -> None:
    for message in get_test_msg(name):
        message.alignment_check = 123_456_789
        data = to_cdr(message)
        end = count_nested(data, type(message))
        assert data[end - 4 : end] == (123_456_789).to_bytes(4, "little")  # the last field


@pytest.mark.parametrize(
    ("message_class", "text"),
    [
        (Path, b'{"poses":[%s]}' % b",".join([b"{}"] * 10_000)),
        (MarkerArray, b'{"markers":[%s]}' % b",".join([b'{"points":[%s]}' % b",".join([b"{}"] * 5_000)] * 40)),
        (JointTrajectory, b'{"joint_names":[%s]}' % b",".join([b'""'] * 10_001)),
    ],
)
def test_many_short_arrays_are_refused_as_one_long_one_is(message_class: Any, text: bytes) -> None:
    with pytest.raises(InvalidField, match=r"at most 10,?000"):
        codec(message_class).parse(orjson.loads(text))


def test_a_long_trajectory_is_read() -> None:
    """Numbers count little: a thousand points of six joints are no burden."""
    points = [{"positions": [1.0] * 6, "velocities": [0.1] * 6, "effort": [2.0] * 6}] * 1_000
    message = codec(JointTrajectory).parse({"joint_names": list("abcdef"), "points": points})
    assert len(message.points) == 1_000


@pytest.mark.timeout(PATIENCE)
@pytest.mark.parametrize(("poses", "in_thread"), [(3, False), (MAX_NESTED // 7, True)])
async def test_what_is_long_is_read_in_a_thread(poses: int, in_thread: bool) -> None:
    seen: list[int] = []

    class Pose(dict[str, Any]):
        def items(self) -> Any:
            seen.append(threading.get_ident())
            return super().items()

    message = await codec(Path).read({"poses": [Pose() for _ in range(poses)]})
    assert len(message.poses) == poses
    assert (seen[-1] != threading.get_ident()) is in_thread
    assert len(seen) <= FEW_NESTED + poses


@given(st.recursive(st.integers(), lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20))
def test_short_values_are_not_long(value: Any) -> None:
    assert not is_long(value)
    assert is_long([value] * FEW_NESTED)

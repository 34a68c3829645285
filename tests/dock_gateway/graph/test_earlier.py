"""What a later reader of a latched topic gets: what a new subscription would get from the publishers."""

from types import SimpleNamespace
from typing import Any, cast

from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.graph import TRANSFORMS, Endpoint, Quality, Topic
from dock_gateway.graph.earlier import MAX_MESSAGES, EarlierMessages
from dock_gateway.graph.subscription import Listening, listening_for
from tf2_msgs.msg import TFMessage


def message(data: Any, kind: str = TRANSFORMS) -> Any:
    return SimpleHashed(data, SimpleNamespace(name=kind, decode=lambda given: given))


class SimpleHashed:
    """A message whose decoded form is its data."""

    def __init__(self, data: Any, kind: Any) -> None:
        self.data, self.kind, self.size = data, kind, 100


def transforms(frames: dict[str, float]) -> TFMessage:
    links = [TransformStamped(child_frame_id=frame) for frame in frames]
    for each, x in zip(links, frames.values(), strict=True):
        each.transform.translation.x = x
    return TFMessage(transforms=links)


@given(st.lists(st.dictionaries(st.sampled_from("abcdef"), st.floats(0, 9), max_size=3), max_size=40))
def test_the_newest_transform_of_each_frame_is_kept_and_nothing_needless(sent: list[dict[str, float]]) -> None:
    earlier, newest = EarlierMessages(), dict[str, float]()
    for frames in sent:
        earlier.add(cast("Any", message(transforms(frames))))
        newest |= frames
    found: dict[str, float] = {}
    for each in earlier:
        found |= {link.child_frame_id: link.transform.translation.x for link in cast("Any", each).data.transforms}
    assert found == newest
    assert len(list(earlier)) <= len(newest) + 1  # one without frames


def test_frames_of_many_publishers_outlast_one_that_repeats_itself() -> None:
    earlier = EarlierMessages()
    for index in range(300):
        earlier.add(message(transforms({f"part{index}": 1.0})))
    for _ in range(2 * MAX_MESSAGES):
        earlier.add(message(transforms({"part7": 1.0})))
    assert len(list(earlier)) == 300
    for index in range(2 * MAX_MESSAGES):
        earlier.add(message(transforms({f"invented{index}": 1.0})))
    assert len(list(earlier)) == MAX_MESSAGES


def test_of_other_messages_the_last_one_is_kept() -> None:
    earlier = EarlierMessages()
    for data in ("a", "b", "c"):
        earlier.add(message(data, "std_msgs/msg/String"))
    damaged = message("none", TRANSFORMS)
    assert [each.data for each in earlier] == ["c"]
    earlier.add(damaged)
    assert list(earlier) == [damaged]
    earlier.clear()
    assert not list(earlier)


def publishers(name: str, *durabilities: str, reliability: str = "reliable") -> Topic:
    qualities = [Quality(reliability, each, "keep_last", 1, None, None, "automatic") for each in durabilities]
    return Topic(name, [Endpoint("/node", TRANSFORMS, quality) for quality in qualities], [])


def test_one_publisher_of_fixed_frames_that_keeps_them_is_enough() -> None:
    """As in tf2, which never asks whether others keep theirs."""
    latched = Listening(TRANSFORMS, reliable=True, latched=True)
    volatile = Listening(TRANSFORMS, reliable=True, latched=False)
    for name in ("/tf_static", "/robot1/tf_static"):
        assert listening_for(publishers(name, "transient_local", "volatile"), None) == latched
        assert listening_for(publishers(name, "volatile", "volatile"), None) == volatile
    assert listening_for(publishers("/map", "transient_local", "volatile"), None) == volatile

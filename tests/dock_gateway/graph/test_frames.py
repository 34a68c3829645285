"""Frames as tf2 relates them, whoever publishes them and in whatever order."""

import math
from types import SimpleNamespace
from typing import Any, cast

import pytest
from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.graph.frames import Frames
from robot_io.transform_tree import TransformError
from tf2_msgs.msg import TFMessage

MOVING, FIXED = "/tf", "/tf_static"


def link(child: str, x: float, parent: str = "map") -> TransformStamped:
    stamped = TransformStamped(child_frame_id=child)
    stamped.header.frame_id = parent
    stamped.transform.translation.x = x
    return stamped


async def frames_of(*messages: tuple[str, list[TransformStamped]]) -> Frames:
    frames = Frames(cast("Any", None), cast("Any", None), MOVING)
    for topic, transforms in messages:
        kind = SimpleNamespace(decode=lambda message: message)
        data = TFMessage(transforms=transforms)
        await frames.offer(cast("Any", SimpleNamespace(topic=topic, kind=kind, data=data, size=100)))
    return frames


def x_of(frames: Frames, frame: str) -> float:
    return frames.locate(frame, "map").translation[0]


async def test_a_wrong_transform_does_not_hide_the_others_of_its_message(caplog: pytest.LogCaptureFixture) -> None:
    wrong = [link("a", math.nan), link("", 1.0), link("map", 1.0), link("b", 1.0, parent=""), link("c" * 999, 1.0)]
    frames = await frames_of((FIXED, [*wrong, link("odom", 2.0)]))
    assert x_of(frames, "odom") == 2.0
    assert len(caplog.records) == 1


async def test_a_slash_before_a_name_says_nothing() -> None:
    frames = await frames_of((FIXED, [link("/odom", 1.0, parent="/map"), link("base", 1.0, parent="odom")]))
    assert x_of(frames, "base") == 2.0


@given(st.lists(st.tuples(st.sampled_from((MOVING, FIXED)), st.sampled_from("abc"), st.integers(0, 9)), max_size=30))
async def test_the_last_transform_of_a_frame_counts_on_whichever_topic(told: list[tuple[str, str, int]]) -> None:
    """As in tf2. Fixed ones count for all times, moving ones for theirs, which is that of their stamp."""
    frames = await frames_of(*((topic, [link(child, float(x))]) for topic, child, x in told))
    last = {child: float(x) for _, child, x in told}
    for child in "abc":
        if child in last:
            assert x_of(frames, child) == last[child]
        else:
            with pytest.raises(TransformError):
                x_of(frames, child)

"""Recordings that are damaged or made up: what Hypothesis makes of a real one."""

import json
import struct
from collections.abc import Sequence
from io import BytesIO
from typing import Any

import orjson
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from robot_io.recording import EVENTS, Sample, event_sample, event_text

YEAR_NS = 365 * 24 * 3600 * 10**9
STAMPS = st.one_of(
    st.sampled_from([0, 1, 2**31, 2**62, 2**63 - 1, 2**63, 2**64 - 1]), st.integers(0, 2**64 - 1), st.just(YEAR_NS)
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=5),
    lambda each: st.lists(each, max_size=3) | st.dictionaries(st.text(max_size=5), each, max_size=3),
    max_leaves=8,
)
KEYS = (
    "type", "status", "goal_id", "action_name", "action_type", "goal", "stage", "error", "values", "node",
)  # fmt: skip
TYPES = (
    "sensor_msgs/msg/BatteryState", "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "geometry_msgs/msg/Twist",
    "tf2_msgs/msg/TFMessage", "std_msgs/msg/String", "no type", "",
)  # fmt: skip


def as_file(samples: Sequence[Sample], compression: CompressionType = CompressionType.ZSTD) -> bytes:
    """A file with these messages, whatever their types and stamps are."""
    output = BytesIO()
    writer = Writer(output, compression=compression)
    writer.start("ros2", "test")
    channels: dict[tuple[str, str], int] = {}
    for sample in samples:
        key = sample.topic, sample.kind
        if key not in channels:
            schema = writer.register_schema(sample.kind, "ros2msg", b"")
            channels[key] = writer.register_channel(sample.topic, "cdr", schema, {"ros_type": sample.kind})
        writer.add_message(channels[key], sample.received_ns, sample.data, sample.source_ns)
    writer.finish()
    return output.getvalue()


@st.composite
def odd_events(draw: st.DrawFn, sample: Sample) -> Sample:
    """An event with other values, without some, or no event at all."""
    document: Any = orjson.loads(event_text(sample))
    if draw(st.booleans()):
        document = draw(JSON)
    else:
        key = draw(st.sampled_from(KEYS))
        if draw(st.booleans()):
            document.pop(key, None)
        else:
            document[key] = draw(JSON | st.sampled_from(["status", "parameters", "//", "/a b", "executing", "nan"]))
    text = json.dumps(document).encode(errors="replace")
    if draw(st.integers(0, 9)) == 0:
        text = b"[" * 100_000
    return event_sample(text, sample.received_ns)


@st.composite
def odd_messages(draw: st.DrawFn, sample: Sample) -> Sample:
    """A message with another stamp, type or topic, or with other bytes."""
    data = bytearray(sample.data)
    match draw(st.sampled_from(["stamp", "later", "kind", "bytes", "length", "cut", "event"])):
        case "stamp":
            return sample._replace(source_ns=draw(STAMPS), received_ns=draw(STAMPS))
        case "later":
            later = sample.received_ns + draw(st.sampled_from([1, 10**9, 31 * 10**9, 10**13, YEAR_NS * 3 // 2]))
            return sample._replace(source_ns=later, received_ns=later)
        case "kind":
            return sample._replace(kind=draw(st.sampled_from(TYPES)))
        case "event" if sample.topic == EVENTS:
            return draw(odd_events(sample))
        case "cut":
            del data[draw(st.integers(0, len(data))) :]
        case "length" if len(data) >= 8:
            at = draw(st.integers(4, len(data) - 4))
            data[at : at + 4] = struct.pack("<I", draw(st.sampled_from([2**31 - 1, 2**31, 2**32 - 1, 10**6])))
        case _:
            for at in draw(st.lists(st.integers(0, max(0, len(data) - 1)), max_size=min(20, len(data)))):
                data[at] = draw(st.integers(0, 255))
    return sample._replace(data=bytes(data))


@st.composite
def odd_samples(draw: st.DrawFn, samples: Sequence[Sample]) -> list[Sample]:
    """The messages of a recording, of which some are odd, missing, or elsewhere. Each kind of topic is as likely."""
    found = list(samples)
    topics = sorted({sample.topic for sample in found})
    for _ in range(draw(st.integers(1, 12))):
        of_topic = [at for at, sample in enumerate(found) if sample.topic == draw(st.sampled_from(topics))]
        if not of_topic:
            continue
        at = draw(st.sampled_from(of_topic))
        match draw(st.sampled_from(["odd", "odd", "gone", "all odd", "moved"])):
            case "odd":
                found[at] = draw(odd_messages(found[at]))
            case "gone":
                del found[at]
            case "moved":
                found.append(found.pop(at))
            case _:  # each message of the topic in the same way
                odd = draw(odd_messages(found[at]))
                for each in of_topic:
                    found[each] = found[each]._replace(kind=odd.kind, data=odd.data)
    return found


@st.composite
def damaged(draw: st.DrawFn, file: bytes) -> bytes:
    """The bytes of a file, some of which are others, or missing."""
    data = bytearray(file)
    for _ in range(draw(st.integers(0, 10))):
        data[draw(st.integers(0, len(data) - 1))] = draw(st.integers(0, 255))
    if draw(st.booleans()):  # a length, somewhere
        at = draw(st.integers(0, len(data) - 8))
        data[at : at + 8] = struct.pack("<Q", draw(STAMPS))
    if draw(st.booleans()):
        del data[draw(st.integers(0, len(data))) :]
    return bytes(data)


def worst(samples: Sequence[Sample]) -> dict[str, list[Sample]]:
    """A recording of a goal with what has no place in one, by what it is."""
    years = samples[-1].received_ns + 47 * 10**15
    events = {
        "an action that is a number": {"action_name": 7},
        "an action that is no name": {"action_name": "/../__ns:=x y"},
        "another robot's action": {"action_name": "/a/b/c/connect_to_charging_dock"},
        "a goal that is a list": {"goal": [1, 2]},
        "a state of odd battery": {"goal": {"desired_battery_state": {"power_supply_status": 10**30, "location": {}}}},
        "an odd stage": {"stage": ["CONTROLLING"], "error": [1]},
        "another goal's id": {"goal_id": "' or 1"},
        "odd values": {"values": {"controller": 5, "controller_frequency": 1e300, "blocked_after": -1, "x y": 1}},
        "odd texts": {"values": {"controller": "}{: &a *a", "dock_database": "/dev/zero", "stop_topics": ["//"]}},
        "no values": {"values": [1, {}]},
    }
    found = {name: [_other_event(each, changes) for each in samples] for name, changes in events.items()}
    found["events that are lists"] = [
        event_sample(b"[[]]", each.received_ns) if each.topic == EVENTS else each for each in samples
    ]
    found["stamps 1.5 years apart"] = [*samples, samples[-1]._replace(source_ns=years, received_ns=years)]
    found["a message every 29 s for 1.5 years"] = [
        *samples[:-1],
        *(
            samples[-1]._replace(source_ns=at, received_ns=at)
            for at in range(samples[-1].received_ns, years, 29 * 10**9)
            if at < samples[-1].received_ns + 29 * 10**9 * 5000
        ),
    ]
    for kind in ("sensor_msgs/msg/BatteryState", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"):
        found[f"{kind} that is cut off"] = [
            each._replace(data=each.data[:20]) if each.kind == kind else each for each in samples
        ]
        found[f"{kind} of 255"] = [
            each._replace(data=each.data[:4] + b"\xff" * (len(each.data) - 4)) if each.kind == kind else each
            for each in samples
        ]
    return found


def _other_event(sample: Sample, changes: dict[str, Any]) -> Sample:
    if sample.topic != EVENTS:
        return sample
    document = orjson.loads(event_text(sample))
    return event_sample(
        json.dumps(document | {key: value for key, value in changes.items() if key in document}).encode(),
        sample.received_ns,
    )

"""What is news in a status message. The messages are real ones, serialized by ROS."""

import uuid

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from dock_gateway.core.goal import FROM_ROS
from dock_gateway.core.goal import GoalStatus as Status
from dock_gateway.ros.status import LIFE_INTERVAL, StatusReader, StatusReport

RUNNING, ENDED = GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_SUCCEEDED
Entry = tuple[uuid.UUID, int, int]


def message(*entries: Entry) -> bytes:
    """Ids, seconds and states."""
    array = GoalStatusArray()
    for goal_id, seconds, status in entries:
        entry = GoalStatus(status=status)
        entry.goal_info.goal_id.uuid = list(goal_id.bytes)
        entry.goal_info.stamp.sec, entry.goal_info.stamp.nanosec = seconds, 7
        array.status_list.append(entry)
    return bytes(serialize_message(array))


def goal(number: int) -> uuid.UUID:
    return uuid.UUID(int=number)


def numbers(reports: list[StatusReport]) -> list[int]:
    return [uuid.UUID(report.goal_id).int for report in reports]


@given(st.lists(st.tuples(st.uuids(), st.integers(-(2**31), 2**31 - 1), st.integers(-128, 127)), max_size=20))
def test_a_message_is_read_as_ros_reads_it(entries: list[Entry]) -> None:
    distinct = list({entry[0]: entry for entry in entries}.values())
    assert StatusReader().read(message(*distinct)) == [
        StatusReport(str(goal_id), FROM_ROS[status], seconds * 1_000_000_000 + 7)
        for goal_id, seconds, status in distinct
        if status in FROM_ROS
    ]


def test_the_other_byte_order() -> None:
    one = bytes(range(16)) + (5).to_bytes(4, "big") + (7).to_bytes(4, "big") + b"\2"
    two = bytes(range(16, 32)) + bytes(3) + (6).to_bytes(4, "big") + bytes(4) + b"\4"
    first, second = StatusReader().read(b"\0\0\0\0" + (2).to_bytes(4, "big") + one + two)
    assert first == StatusReport("00010203-0405-0607-0809-0a0b0c0d0e0f", Status.EXECUTING, 5_000_000_007)
    assert (second.status, second.accepted_ns) == (Status.SUCCEEDED, 6_000_000_000)


@given(st.binary(max_size=100))
def test_bytes_that_are_no_message_do_no_harm(data: bytes) -> None:
    try:
        StatusReader().read(data)
    except ValueError:
        return


def test_a_message_that_promises_more_goals_than_it_has() -> None:
    with pytest.raises(ValueError, match="goals"):
        StatusReader().read(b"\0\1\0\0\xff\xff\xff\xff" + bytes(25))


def test_goals_that_run_are_news_each_time_and_ended_ones_once() -> None:
    reader = StatusReader()
    both = message((goal(1), 1, RUNNING), (goal(2), 1, ENDED))
    assert numbers(reader.read(both)) == [1, 2]
    assert numbers(reader.read(both)) == [1]
    assert [report.status for report in reader.read(message((goal(1), 1, ENDED), (goal(2), 1, ENDED)))] == ["succeeded"]
    assert reader.read(message()) == []
    assert numbers(reader.read(both)) == [1, 2]


def test_of_too_many_goals_those_that_run_come_first_then_the_newest() -> None:
    reader = StatusReader(max_reports=3)
    entries = [(goal(1), 10, ENDED), (goal(2), 30, ENDED), (goal(3), 5, RUNNING), (goal(4), 20, ENDED)]
    assert numbers(reader.read(message(*entries))) == [2, 3, 4]
    assert numbers(reader.read(message(*entries))) == [1, 3], "what was left out comes next"
    entries[2] = (goal(3), 5, ENDED)
    assert numbers(reader.read(message(*entries))) == [3]
    running = [(goal(number), number, RUNNING) for number in range(10, 15)]
    assert numbers(reader.read(message(*entries, *running))) == [12, 13, 14]
    assert numbers(reader.read(message(*entries, *running))) == [10, 11, 14]


def test_goals_that_are_not_admitted_are_news_again_in_the_next_message() -> None:
    admitted: set[bytes] = set()
    reader = StatusReader(admitted.__contains__)
    both = message((goal(1), 1, RUNNING), (goal(2), 1, ENDED))
    assert reader.read(both) == []
    admitted.add(goal(2).bytes)
    assert numbers(reader.read(both)) == [2]
    admitted.add(goal(1).bytes)
    assert numbers(reader.read(both)) == [1]


def test_messages_without_news_are_told_now_and_then() -> None:
    reader = StatusReader()
    running = message((goal(1), 1, RUNNING))
    reader.read(running)
    assert reader.worth_telling(0.0)
    reader.read(running)
    assert not reader.worth_telling(LIFE_INTERVAL / 2)
    assert reader.worth_telling(LIFE_INTERVAL)
    reader.read(message((goal(1), 1, ENDED)))
    assert reader.worth_telling(LIFE_INTERVAL), "a change is told at once"

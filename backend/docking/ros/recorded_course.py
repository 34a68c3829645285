"""Reads the course of a recorded goal by its docking server: its beginning, its stages and its end.

The gateway notes the same, but later on a busy machine.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

from action_msgs.msg import GoalStatusArray
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from docking.goal.outcome import End
from docking.replay.course import Course
from docking.replay.recorded_goal import NS, RecordedGoal
from robot_io.recording import Sample

DIAGNOSTICS = "/diagnostics"
ENDS = frozenset(end.value for end in End)


def as_the_server_said(goal: RecordedGoal) -> RecordedGoal:
    """Return a recorded goal with the moments that its server published, where the recording has them."""
    accepted = [sample.received_ns for sample in goal.samples if _accepts(sample, goal)]
    began_ns = min(accepted, default=goal.began_ns)
    own = goal.course
    later = (goal.began_ns - began_ns) / NS
    course = Course([(at + later, stage) for at, stage in own.stages], [], own.end, own.error_code, own.error_msg)
    course.ended_at = own.ended_at + later
    said = [(at_ns, values) for sample in goal.samples for at_ns, values in _reports(sample, goal.goal_id)]
    if any(values["stage"] not in ENDS for _, values in said):
        course.stages = []
    for at_ns, values in said:
        at = (at_ns - began_ns) / NS
        if values["stage"] not in ENDS:
            course.enter(at, values["stage"])
        elif values["stage"] == own.end:
            course.ended_at = min(course.ended_at, at)
    return replace(goal, began_ns=began_ns, course=course)


def _accepts(sample: Sample, goal: RecordedGoal) -> bool:
    if sample.topic != f"{goal.action}/_action/status":
        return False
    goals = _read(sample, GoalStatusArray, "status_list")
    return any(bytes(each.goal_info.goal_id.uuid) == goal.uuid for each in goals)


def _reports(sample: Sample, goal_id: str) -> Iterator[tuple[int, dict[str, str]]]:
    if sample.topic == DIAGNOSTICS:
        for status in _read(sample, DiagnosticArray, "status"):
            values = {value.key: value.value for value in status.values}
            if values.get("goal_id") == goal_id and values.get("stage"):
                yield sample.received_ns, values


def _read(sample: Sample, kind: Any, field: str) -> list[Any]:
    with suppress(Exception):  # whatever the bytes of others bring about
        return list(getattr(deserialize_message(sample.data, kind), field))
    return []

"""A goal as the gateway has recorded it."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from docking.replay.course import Course
from robot_io.recording import EVENTS, Sample, event_text, read

ENDS = {"succeeded": "SUCCEEDED", "canceled": "CANCELED", "aborted": "ABORTED"}
NS = 1_000_000_000
QOS = "qos_overrides."


@dataclass(frozen=True)
class RecordedGoal:
    """A goal, and what its robot said meanwhile.

    Attributes:
        goal_id: Its id.
        action: Absolute name of its action.
        action_type: Such as `action_tutorials_interfaces/action/ConnectToChargingDock`.
        request: The goal's message, as JSON has it.
        parameters: Those of the action server, by name; empty if it did not tell them.
        began_ns: When the action server had accepted it, in ns since 1970.
        course: What became of it; its velocities are among the samples.
        samples: All messages, in the order in which they came.
    """

    goal_id: str
    action: str
    action_type: str
    request: dict[str, Any]
    parameters: dict[str, Any]
    began_ns: int
    course: Course
    samples: list[Sample]

    @property
    def robot(self) -> str:
        """The namespace of the robot."""
        return self.action.rpartition("/")[0] or "/"

    def seconds(self, sample: Sample) -> float:
        """Return when a message came, in seconds since the goal was accepted."""
        return (sample.received_ns - self.began_ns) / NS

    def topics(self) -> dict[str, str]:
        """Return all topics with their types."""
        return {sample.topic: sample.kind for sample in self.samples}


def read_goal(path: Path) -> RecordedGoal:
    """Read a recording.

    Raises:
        ValueError: There is no goal in it that an action server had accepted; the error says why, as a sentence.
    """
    try:
        samples = sorted(_punctual(list(read(path))), key=lambda sample: sample.received_ns)
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from error
    except ImportError as error:
        raise ValueError(f"recordings are read with the Python package mcap, which does not load: {error}") from error
    states = [(sample, json.loads(event_text(sample))) for sample in samples if sample.topic == EVENTS]
    accepted = [
        (sample, state)
        for sample, state in states
        if state.get("type") == "status" and state.get("status") not in ("pending", "rejected")
    ]
    if not samples:
        raise ValueError(f"{path} is no recording of a goal: there is no message in it that can be read")
    if not accepted:
        raise ValueError(f"{path} has no goal that an action server accepted")
    # Goals of the robot's other actions may be in the recording: it is about the last one that has begun.
    goal_id = accepted[-1][1]["goal_id"]
    own = [(sample, state) for sample, state in accepted if state["goal_id"] == goal_id]
    first, about = own[0]
    goal = RecordedGoal(
        goal_id,
        about["action_name"],
        about["action_type"],
        about.get("goal") or {},
        _parameters(state for _, state in states if state.get("goal_id") == goal_id),
        first.received_ns,
        Course(),
        samples,
    )
    for sample, state in own:
        _note(goal.course, goal.seconds(sample), state)
    return goal


def _parameters(states: Iterable[dict[str, Any]]) -> dict[str, Any]:
    values: dict[str, Any] = next((state["values"] for state in states if state.get("type") == "parameters"), {})
    return {name: value for name, value in values.items() if value not in (None, []) and not name.startswith(QOS)}


def _punctual(samples: list[Sample]) -> Iterator[Sample]:
    """Yield the messages as they would have come without delays: a busy gateway notes them late.

    The least delay on a topic has the difference of the clocks in it.
    """
    least: dict[str, int] = {}
    for sample in samples:
        delay = sample.received_ns - sample.source_ns
        least[sample.topic] = min(delay, least.get(sample.topic, delay))
    for sample in samples:
        yield sample._replace(received_ns=sample.source_ns + least[sample.topic])


def _note(course: Course, at: float, state: dict[str, Any]) -> None:
    course.ended_at = at
    end = ENDS.get(state["status"], "")
    if state.get("stage") and not end:
        course.enter(at, state["stage"])
    if end:
        error = state.get("error") or {}
        course.end = end
        course.error_code, course.error_msg = str(error.get("code", "")).upper(), str(error.get("detail", ""))

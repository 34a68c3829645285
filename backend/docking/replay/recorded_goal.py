"""A goal as the gateway has recorded it. The file may be damaged or made up."""

import json
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any
from uuid import UUID

from docking.replay.course import Course
from robot_io.recording import EVENTS, Sample, event_text, read

ENDS = {"succeeded": "SUCCEEDED", "canceled": "CANCELED", "aborted": "ABORTED"}
NS = 1_000_000_000
QOS = "qos_overrides."
MOST_MESSAGES, MOST_BYTES = 2_000_000, 1_500_000_000
"""What is replayed of a file, and its bytes."""
SILENCE = 30.0
"""Seconds in which no topic says anything: the gateway did not record what came then."""
LONGEST = 3 * 3600.0
"""Seconds of a goal that are replayed."""
LATEST_NS = 2**63
"""No clock of ROS tells a later moment."""
_ACTION = re.compile(r"(?:/[A-Za-z_]\w*)+", re.ASCII)
_PARAMETER = re.compile(r"[A-Za-z_][\w.]*", re.ASCII)
INTEGERS = range(-(2**63), 2**63)


@dataclass(frozen=True)
class RecordedGoal:
    """A goal, and what its robot said while it ran.

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

    @property
    def uuid(self) -> bytes:
        """The id, as ROS has it."""
        return UUID(self.goal_id).bytes

    def seconds(self, sample: Sample) -> float:
        """Return when a message came, in seconds since the goal was accepted."""
        return (sample.received_ns - self.began_ns) / NS

    def topics(self) -> dict[str, str]:
        """Return all topics with their types."""
        return {sample.topic: sample.kind for sample in self.samples}

    @property
    def heard_until(self) -> float:
        """The last moment up to which all that the robot said is here, in seconds since the goal was accepted."""
        times = [at for sample in self.samples if (at := self.seconds(sample)) >= 0.0]
        gaps = (at for at, following in pairwise([0.0, *times]) if following - at > SILENCE)
        return min(next(gaps, math.inf), LONGEST)


def read_goal(path: Path) -> RecordedGoal:
    """Read a recording.

    Raises:
        ValueError: There is no goal in it that an action server had accepted; the error says why, as a sentence.
    """
    try:
        samples = sorted(_punctual(list(_some(read(path)))), key=lambda sample: sample.received_ns)
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from error
    except ImportError as error:
        raise ValueError(f"recordings are read with the Python package mcap, which does not load: {error}") from error
    if not samples:
        raise ValueError(f"{path} is no recording of a goal: there is no message in it that can be read")
    states = [(sample, state) for sample in samples if (state := _state(sample)) is not None]
    accepted = [
        (sample, state)
        for sample, state in states
        if state.get("type") == "status" and state.get("status") not in ("pending", "rejected") and _has_goal(state)
    ]
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
        about["goal"] if isinstance(about.get("goal"), dict) else {},
        _parameters(state for _, state in states if state.get("goal_id") == goal_id),
        first.received_ns,
        Course(),
        samples,
    )
    for sample, state in own:
        _note(goal.course, goal.seconds(sample), state)
    return goal


def _some(samples: Iterable[Sample]) -> Iterator[Sample]:
    """Yield as many messages as can be replayed."""
    left = MOST_BYTES
    for number, sample in enumerate(samples):
        left -= len(sample.data)
        if number >= MOST_MESSAGES or left < 0:
            return
        yield sample


def _state(sample: Sample) -> dict[str, Any] | None:
    """Return what an event says; None if the message is none."""
    if sample.topic != EVENTS:
        return None
    try:
        state = json.loads(event_text(sample))
    except (ValueError, RecursionError):
        return None
    return state if isinstance(state, dict) else None


def _has_goal(state: dict[str, Any]) -> bool:
    """Return whether an event says what goal it is about."""
    if not all(isinstance(state.get(name), str) for name in ("goal_id", "status", "action_name", "action_type")):
        return False
    try:
        return str(UUID(state["goal_id"])) == state["goal_id"] and bool(_ACTION.fullmatch(state["action_name"]))
    except ValueError:
        return False


def _parameters(states: Iterable[dict[str, Any]]) -> dict[str, Any]:
    values: Any = next((state.get("values") for state in states if state.get("type") == "parameters"), {})
    if not isinstance(values, dict):
        return {}
    return {name: value for name, value in values.items() if _is_parameter(name, value)}


def _is_parameter(name: str, value: object) -> bool:
    if isinstance(value, list):
        return bool(value) and len({type(each) for each in value}) == 1 and _is_parameter(name, value[0])
    if isinstance(value, int) and value not in INTEGERS:
        return False
    return isinstance(value, bool | int | float | str) and bool(_PARAMETER.fullmatch(name)) and not name.startswith(QOS)


def _punctual(samples: list[Sample]) -> Iterator[Sample]:
    """Yield the messages as they would have come without delays: a busy gateway notes them late.

    The least delay on a topic has the difference of the clocks in it.
    """
    least: dict[str, int] = {}
    for sample in samples:
        delay = sample.received_ns - sample.source_ns
        least[sample.topic] = min(delay, least.get(sample.topic, delay))
    for sample in samples:
        at_ns = sample.source_ns + least[sample.topic]
        if 0 <= at_ns < LATEST_NS:
            yield sample._replace(received_ns=at_ns)


def _note(course: Course, at: float, state: dict[str, Any]) -> None:
    course.ended_at = at
    end, stage = ENDS.get(state["status"], ""), state.get("stage")
    if isinstance(stage, str) and stage and not end:
        course.enter(at, stage)
    if end:
        error = state.get("error")
        course.end = end
        course.error_code, course.error_msg = "", ""
        if isinstance(error, dict):
            course.error_code, course.error_msg = str(error.get("code", "")).upper(), str(error.get("detail", ""))

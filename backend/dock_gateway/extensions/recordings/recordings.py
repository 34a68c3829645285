"""The recordings, for who asks: finds them, or says why there is none."""

import asyncio
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from io import BytesIO
from typing import Any

from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import nanoseconds
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.grant import Grant
from dock_gateway.core.png import SIGNATURE
from dock_gateway.extensions.recordings.mcap_file import McapFile
from dock_gateway.extensions.recordings.recorder import Recorder
from dock_gateway.extensions.recordings.replay import Replay
from dock_gateway.extensions.recordings.store import Recording, RecordingStore
from dock_gateway.extensions.recordings.topics import CAMERA
from dock_gateway.ros.raw_port import EchoType
from robot_io.recording import EVENTS, Sample, read

OFF = "Recordings are switched off (`--recordings none`)."
# Recordings of which it is remembered whether they have a picture: each has to be opened for that.
PICTURES_KNOWN = 10_000
PICTURES = {b"\xff\xd8\xff": "image/jpeg", SIGNATURE: "image/png"}


class Recordings:
    """The recordings of goals, and what has been heard of robots in the last seconds.

    Args:
        store: The files.
        recorder: Writes them; None if recordings are switched off.
    """

    def __init__(self, store: RecordingStore, recorder: Recorder | None) -> None:
        self._store = store
        self._recorder = recorder
        self._picture_topic = lru_cache(PICTURES_KNOWN)(partial(_picture_topic, store))

    def is_running(self, goal_id: str) -> bool:
        """Return whether a goal is being recorded."""
        return self._recorder is not None and self._recorder.is_running(goal_id)

    async def find(self, goal: Goal) -> Recording:
        """Return the recording of a goal.

        Raises:
            NotFound: There is none (`recording_not_found`); the detail says why.
        """
        running = self.is_running(goal.goal_id)
        if running or (found := await asyncio.to_thread(self._store.find, goal.goal_id)) is None:
            raise NotFound(self._why_none(goal, running=running), code="recording_not_found")
        return found

    def _why_none(self, goal: Goal, *, running: bool) -> str:
        if running:
            return "The goal is being recorded; the recording is complete 2 s after the goal's end."
        if (known := self._store.why_none(goal.goal_id)) is not None:
            return known
        if self._recorder is None:
            return OFF
        if goal.status is GoalStatus.SUCCEEDED:
            return "The goal succeeded: such recordings are kept only with `--recordings all`, and deleted first."
        return "There is none at this gateway: the goal ran without it, or the recording was deleted."

    async def describe(self, goals: Sequence[Goal], grant: Grant) -> list[dict[str, Any]]:
        """Return the recording of each goal as `GoalRecording` has it; a picture only if the grant covers it."""
        running = {goal.goal_id for goal in goals if self.is_running(goal.goal_id)}
        unknown = [goal.goal_id for goal in goals if goal.goal_id not in running and self._may_have(goal.goal_id)]
        found = await asyncio.to_thread(self._look, unknown) if unknown else {}
        return [self._describe(goal, found.get(goal.goal_id), grant, running=goal.goal_id in running) for goal in goals]

    def _may_have(self, goal_id: str) -> bool:
        return self._store.why_none(goal_id) is None

    def _look(self, goal_ids: Iterable[str]) -> dict[str, tuple[Recording, str | None]]:
        """Return the recordings that there are, and the topic of the picture of each."""
        recordings = (self._store.find(goal_id) for goal_id in goal_ids)
        return {found.goal_id: (found, self._picture_topic(found)) for found in recordings if found is not None}

    def _describe(
        self, goal: Goal, found: tuple[Recording, str | None] | None, grant: Grant, *, running: bool
    ) -> dict[str, Any]:
        if found is None:
            state, reason = "running" if running else "none", self._why_none(goal, running=running)
            return {"state": state, "size_bytes": None, "picture": False, "reason": reason}
        recording, topic = found
        picture = topic is not None and grant.covers_topic(topic)
        return {"state": "complete", "size_bytes": recording.size, "picture": picture, "reason": None}

    async def narrowed(self, recording: Recording, grant: Grant) -> memoryview:
        """Return a recording with the topics that a grant covers.

        Raises:
            NotFound: It has been deleted (`recording_not_found`).
        """
        try:
            return await asyncio.to_thread(_narrow, recording, covers(grant))
        except FileNotFoundError:
            raise NotFound("It has just been deleted.", code="recording_not_found") from None

    async def replay(
        self, recording: Recording, goal: Goal, grant: Grant, *, velocity: str, robot: str
    ) -> dict[str, Any]:
        """Return what the replay of a goal shows of its recording, of the topics that a grant covers.

        Args:
            recording: The recording.
            goal: Its goal.
            grant: Of who asks.
            velocity: Name of the velocity topic, without its namespace.
            robot: The namespace of its robot.

        Raises:
            NotFound: It has been deleted (`recording_not_found`).
        """
        replay = Replay(nanoseconds(goal.created_at), velocity, robot)
        try:
            return await asyncio.to_thread(replay.read, recording.path, covers(grant))
        except FileNotFoundError:
            raise NotFound("It has just been deleted.", code="recording_not_found") from None

    async def picture(self, recording: Recording, grant: Grant) -> tuple[bytes, str]:
        """Return the last picture of the robot's camera in a recording, and its media type.

        Raises:
            NotFound: There is none (`picture_not_found`).
        """
        sample = await asyncio.to_thread(_last_picture, self._store, recording)
        if sample is None or not grant.covers_topic(sample.topic):
            raise NotFound("The recording has no picture of a camera.", code="picture_not_found")
        data = await asyncio.to_thread(_picture_in, sample)
        if (media_type := _media_type(data)) is None:
            raise NotFound("The last picture is neither JPEG nor PNG.", code="picture_not_found")
        return data, media_type

    async def of_robot(self, robot: str, grant: Grant) -> memoryview:
        """Return what has been heard of a robot in the last seconds, as an MCAP file.

        Raises:
            NotFound: Nothing is kept of it (`recording_not_found`).
        """
        if self._recorder is None:
            raise NotFound(OFF, code="recording_not_found")
        samples = self._recorder.heard_of(robot)
        if samples is None:
            detail = f"Between goals, only {self._recorder.robots} robots are recorded (`--recording-buffer-robots`)."
            raise NotFound(detail, code="recording_not_found")
        covered = covers(grant)
        return await asyncio.to_thread(_as_file, [each for each in samples if covered(each.topic)], {"robot": robot})


def covers(grant: Grant) -> Callable[[str], bool]:
    """Return a function that says which topics of a recording a grant covers."""
    return lambda topic: not grant.actions if topic == EVENTS else grant.covers_topic(topic)


def _narrow(recording: Recording, covered: Callable[[str], bool]) -> memoryview:
    samples = (sample for sample in read(recording.path) if covered(sample.topic))
    return _as_file(samples, {"goal_id": recording.goal_id})


def _last_picture(store: RecordingStore, recording: Recording) -> Sample | None:
    try:
        return store.last_picture(recording)
    except Exception:  # noqa: BLE001 - it has been deleted, or is damaged
        return None


def _picture_in(sample: Sample) -> bytes:
    try:
        return bytes(EchoType(CAMERA).decode(sample.data).data)
    except Exception:  # noqa: BLE001 - whatever the bytes of others bring about
        return b""


def _media_type(data: bytes) -> str | None:
    return next((each for start, each in PICTURES.items() if data.startswith(start)), None)


def _picture_topic(store: RecordingStore, recording: Recording) -> str | None:
    """Return the topic of the picture that a recording has."""
    sample = _last_picture(store, recording)
    return None if sample is None or _media_type(_picture_in(sample)) is None else sample.topic


def _as_file(samples: Iterable[Sample], about: dict[str, str]) -> memoryview:
    output = BytesIO()
    file = McapFile(output)
    file.write(samples)
    file.finish(about)
    return output.getbuffer()

"""Who gets which part of a recording, and which picture."""

import uuid
from pathlib import Path

import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage

from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.extensions.recordings.recordings import OFF, Recordings
from dock_gateway.extensions.recordings.store import Recording, RecordingStore
from dock_gateway.extensions.recordings.topics import CAMERA
from robot_io.recording import EVENTS, Sample, event_sample, read

JPEG = b"\xff\xd8\xff\xe0picture"
CAMERAS = ("/robot1/front/compressed", "/robot2/front/compressed")


def image(topic: str, data: bytes) -> Sample:
    return Sample(topic, CAMERA, serialize_message(CompressedImage(format="jpeg", data=data)), 1, 1)


@pytest.fixture
def store(tmp_path: Path) -> RecordingStore:
    return RecordingStore(tmp_path, 1_000_000, 30, reserve=0)


def record(store: RecordingStore, *samples: Sample) -> Recording:
    goal_id = str(uuid.uuid4())
    opened = store.open(goal_id)
    opened.file.write(samples)
    store.finish(opened, goal_id, {}, failed=True)
    found = store.find(goal_id)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("grant", "topics"),
    [
        (Grant(Role.VIEWER, robots=("/robot1",)), {CAMERAS[0], EVENTS}),
        (Grant(Role.VIEWER, topics=("/robot2/*",)), {CAMERAS[1], EVENTS}),
        (Grant(Role.VIEWER, actions=("/robot1/dock",)), set(CAMERAS)),
    ],
)
async def test_a_limited_grant_gets_only_its_topics(
    store: RecordingStore, tmp_path: Path, grant: Grant, topics: set[str]
) -> None:
    found = record(store, *(image(topic, JPEG) for topic in CAMERAS), event_sample(b"{}", 1))
    file = tmp_path / "narrowed.mcap"
    file.write_bytes(await Recordings(store, None).narrowed(found, grant))
    assert {each.topic for each in read(file)} == topics


async def test_the_last_picture(store: RecordingStore) -> None:
    recordings = Recordings(store, None)
    found = record(store, image(CAMERAS[0], b"\xff\xd8\xffolder"), image(CAMERAS[0], JPEG))
    assert await recordings.picture(found, UNLIMITED) == (JPEG, "image/jpeg")
    with pytest.raises(NotFound):
        await recordings.picture(found, Grant(Role.VIEWER, robots=("/robot2",)))
    with pytest.raises(NotFound, match="neither JPEG nor PNG"):
        await recordings.picture(record(store, image(CAMERAS[0], b"<svg onload=alert()>")), UNLIMITED)
    with pytest.raises(NotFound, match="neither JPEG nor PNG"):
        await recordings.picture(record(store, Sample(CAMERAS[0], CAMERA, b"\xff", 1, 1)), UNLIMITED)
    with pytest.raises(NotFound, match="no picture"):
        await recordings.picture(record(store), UNLIMITED)
    found.path.write_bytes(b"damaged")
    with pytest.raises(NotFound, match="no picture"):
        await recordings.picture(found, UNLIMITED)


async def test_why_there_is_none(store: RecordingStore) -> None:
    goal = Goal(str(uuid.uuid4()), "/dock", "pkg/action/Dock", utc_now(), status=GoalStatus.SUCCEEDED)
    with pytest.raises(NotFound, match=OFF.split("(", maxsplit=1)[0]):
        await Recordings(store, None).find(goal)
    store.note(goal.goal_id, "The disk did not take it.")
    with pytest.raises(NotFound, match="did not take") as none:
        await Recordings(store, None).find(goal)
    assert none.value.code == "recording_not_found"

"""The folder with the recordings: what is kept, what is deleted, and what a killed process leaves."""

import os
import shutil
import time
import uuid
from pathlib import Path
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Twist
from rclpy.serialization import serialize_message

from dock_gateway.extensions.recordings.store import NoRoomError, RecordingStore
from robot_io.recording import Sample, event_sample, read, read_last

DAY = 86_400
TWIST = serialize_message(Twist())


def twist(number: int) -> Sample:
    return Sample("/cmd_vel", "geometry_msgs/msg/Twist", TWIST, number, number)


def store(folder: Path, max_bytes: int = 1_000_000, reserve: int = 0) -> RecordingStore:
    return RecordingStore(folder / "recordings", max_bytes, max_days=30, reserve=reserve)


def record(store: RecordingStore, *samples: Sample, failed: bool = True, age: float = 0) -> str:
    goal_id = str(uuid.uuid4())
    opened = store.open(goal_id)
    opened.file.write(samples)
    store.finish(opened, goal_id, {"goal_id": goal_id}, failed=failed)
    found = store.find(goal_id)
    assert found is not None
    os.utime(found.path, (time.time() - age,) * 2)
    return goal_id


def test_failures_are_kept_longest_and_nothing_too_long(tmp_path: Path) -> None:
    kept = store(tmp_path)
    failed = [record(kept, twist(1), age=age) for age in (300, 200, 100)]
    succeeded = [record(kept, twist(1), failed=False, age=age) for age in (30, 20, 10)]
    record(kept, twist(1), age=31 * DAY)
    largest = max(each.size for each in kept.all())
    limited = store(tmp_path, max_bytes=3 * largest)
    limited.clean()
    assert {each.goal_id for each in limited.all()} == set(failed)
    assert "deleted" in (limited.why_none(succeeded[2]) or "")


@pytest.mark.parametrize("left", [1.0, 0.8, 0.5, 0.0])
def test_what_a_killed_process_leaves_is_finished(tmp_path: Path, left: float) -> None:
    killed = store(tmp_path)
    goal_id = str(uuid.uuid4())
    opened = killed.open(goal_id)
    for first in range(0, 200, 20):
        opened.file.write(twist(first + each) for each in range(20))
    os.truncate(opened.part, int(opened.part.stat().st_size * left))
    opened.close()
    again = store(tmp_path)
    again.recover()
    found = again.find(goal_id)
    assert found is not None
    assert found.failed
    samples = list(read(found.path))
    assert samples == [twist(each) for each in range(len(samples))]
    assert len(samples) in {1.0: (200,), 0.8: (140, 160), 0.5: (80, 100), 0.0: (0,)}[left]
    assert list(found.path.parent.iterdir()) == [found.path]


def test_what_is_still_being_written_is_left_alone(tmp_path: Path) -> None:
    mine, others = store(tmp_path), store(tmp_path)
    goal_id = str(uuid.uuid4())
    opened = mine.open(goal_id)
    opened.file.write([twist(1)])
    others.recover()
    assert others.find(goal_id) is None
    with pytest.raises(BlockingIOError):
        others.open(goal_id)
    mine.finish(opened, goal_id, {}, failed=False)
    found = others.find(goal_id)
    assert found is not None
    assert list(read(found.path)) == [twist(1)]


def test_a_goal_that_goes_on_after_a_restart_has_one_recording(tmp_path: Path) -> None:
    kept = store(tmp_path)
    goal_id = record(kept, twist(1), event_sample(b"{}", 2))
    opened = kept.open(goal_id)
    opened.file.write([twist(3)])
    kept.finish(opened, goal_id, {}, failed=False)
    (found,) = kept.all()
    assert not found.failed
    assert [each.received_ns for each in read(found.path)] == [1, 2, 3]
    last = read_last(found.path, "geometry_msgs/msg/Twist")
    assert last is not None
    assert last.received_ns == 3
    kept.forget(kept.open(goal_id), goal_id, "It succeeded.")
    assert (kept.all(), kept.why_none(goal_id)) == ([], "It succeeded.")


def test_a_link_is_neither_read_nor_written(tmp_path: Path) -> None:
    kept = store(tmp_path)
    goal_id = record(kept, twist(1))
    found = kept.find(goal_id)
    assert found is not None
    secret = tmp_path / "secret"
    secret.write_text("of someone else")
    found.path.unlink()
    found.path.symlink_to(secret)
    (found.path.parent / f"{goal_id}.part").symlink_to(secret)
    assert (kept.find(goal_id), kept.all()) == (None, [])
    with pytest.raises(OSError, match="symbolic links"):
        kept.open(goal_id)
    assert secret.read_text() == "of someone else"


def test_a_full_disk_is_trouble_until_there_is_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    free = 10**6
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=free))
    full = store(tmp_path, reserve=10**7)
    with pytest.raises(NoRoomError, match="stay free") as refused:
        full.open(str(uuid.uuid4()))
    full.complain(refused.value)
    first = full.trouble
    full.complain(refused.value)
    full.clean()
    assert full.trouble == first
    free = 10**8
    full.clean()
    assert full.trouble is None

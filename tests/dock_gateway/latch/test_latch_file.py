"""The file that keeps latched stops, and what keeps it up to date."""

import asyncio
import os
import threading
from datetime import UTC, datetime
from pathlib import Path

import pytest

from dock_gateway.latch.latch_file import NOT_YET, LatchFile, LatchWriter
from dock_gateway.latch.latches import Latch
from tests.support.waiting import until

ADA = Latch(datetime(2026, 11, 21, 3, 32, 40, 123456, UTC), "Ada")
BOB = Latch(datetime(2026, 11, 21, 4, 0, 0, 0, UTC), "Bob")
GOOD = b'"/robot2": {"stopped_at": "2026-11-21T04:00:00Z", "by": "Bob"}'


def test_the_file_gives_back_what_was_written(tmp_path: Path) -> None:
    file = LatchFile(tmp_path / "robots" / "data" / "stops.json")
    assert file.read() == {}
    file.write({"/": ADA, "/robot1": Latch(BOB.stopped_at)})
    assert LatchFile(file.path).read() == {"/": ADA, "/robot1": Latch(BOB.stopped_at)}
    file.write({})
    assert file.read() == {}
    assert [path.name for path in file.path.parent.iterdir()] == ["stops.json"]
    assert file.path.parent.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    ("content", "held"),
    [
        (b"", {"/"}),
        (b"\0" * 100, {"/"}),
        (b"{" + GOOD, {"/"}),  # torn
        (b"[]", {"/"}),
        (b"\xff", {"/"}),
        (b'{"/robot1/": {}, ' + GOOD + b"}", {"/", "/robot1", "/robot2"}),
        (b'{"/robot1": {"stopped_at": 1, "by": null}}', {"/", "/robot1"}),
        (b'{"/robot1": {"stopped_at": "2026-11-21T04:00:00", "by": null}}', {"/", "/robot1"}),
        (b'{"/robot1": null}', {"/", "/robot1"}),
        (b'{"/XAVIER/X/": null}', {"/", "/XAVIER/X"}),
        (b"{" + GOOD + b"}", {"/robot2"}),
    ],
)
def test_what_cannot_be_read_counts_as_a_stop_of_the_robots_of_the_gateway(
    tmp_path: Path, content: bytes, held: set[str]
) -> None:
    path = tmp_path / "stops.json"
    path.write_bytes(content)
    read = LatchFile(path).read()
    assert set(read) == held
    assert all(latch.stopped_at.tzinfo is not None for latch in read.values())
    assert read.get("/robot2", BOB) == BOB


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b'["robot1"]', "no object: ['robot1']"),
        (b'{"/a": {"stopped_at": "2026-11-21T04:00:00", "by": 1}}', "no stop: {'stopped_at'"),
    ],
)
def test_the_log_says_what_cannot_be_read(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, content: bytes, why: str
) -> None:
    path = tmp_path / "stops.json"
    path.write_bytes(content)
    LatchFile(path).read()
    assert why in caplog.text


def test_a_file_that_is_a_folder_counts_as_a_stop(tmp_path: Path) -> None:
    assert set(LatchFile(tmp_path).read()) == {"/"}


def test_it_is_on_the_disk_before_it_takes_the_place_of_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[str] = []
    fsync, replace = os.fsync, Path.replace

    def noted_fsync(number: int) -> None:
        steps.append("folder" if Path(f"/proc/self/fd/{number}").readlink() == tmp_path else "file")
        fsync(number)

    def noted_replace(self: Path, target: Path) -> Path:
        steps.append("replace")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", noted_fsync)
    monkeypatch.setattr(Path, "replace", noted_replace)
    LatchFile(tmp_path / "stops.json").write({"/": ADA})
    assert steps == ["file", "replace", "folder"]


def test_a_disk_that_does_not_take_it_keeps_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = LatchFile(tmp_path / "stops.json")
    file.write({"/": ADA})

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        file.write({})
    assert file.read() == {"/": ADA}
    assert [path.name for path in tmp_path.iterdir()] == ["stops.json"]


async def test_the_newest_is_stored_whatever_comes_between(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, gate = LatchFile(tmp_path / "stops.json"), threading.Event()
    written: list[set[str]] = []
    monkeypatch.setattr(file, "write", lambda held: (gate.wait(10), written.append(set(held))))
    writer = LatchWriter(file, lambda: None)
    for number in range(50):
        writer.put({f"/robot{number}": ADA})
        await asyncio.sleep(0)
    gate.set()
    assert await writer.wait(10.0)
    assert written[-1] == {"/robot49"}
    assert len(written) <= 2
    await writer.close()


async def test_it_tries_again_and_tells_when_that_changes_something(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "folder" / "stops.json"
    path.parent.touch()  # no folder
    problems: list[str | None] = []
    writer = LatchWriter(LatchFile(path), lambda: problems.append(writer.problem), retry_after=0.01)
    writer.put({"/": ADA})
    await until(lambda: len(problems) == 1)
    assert "cannot be written" in (problems[0] or "")
    writer.put({"/": ADA, "/robot1": BOB})
    await asyncio.sleep(0.05)
    path.parent.unlink()
    assert await writer.wait(10.0)
    assert problems[1:] == [None]
    assert set(LatchFile(path).read()) == {"/", "/robot1"}
    assert [record.levelname for record in caplog.records] == ["ERROR", "WARNING"]
    assert "would lose the latest stop" in caplog.messages[0]
    assert "on the disk again" in caplog.messages[1]
    await writer.close()


async def test_a_slow_disk_is_a_problem_until_it_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    file, gate = LatchFile(tmp_path / "stops.json"), threading.Event()
    monkeypatch.setattr(file, "write", lambda _: gate.wait(10))
    problems: list[str | None] = []
    writer = LatchWriter(file, lambda: problems.append(writer.problem))
    assert await writer.wait(0.0)  # nothing to store yet
    writer.put({"/": ADA})
    assert not await writer.wait(0.01)
    assert not await writer.wait(0.01)
    assert problems == [NOT_YET]
    gate.set()
    assert await writer.wait(10.0)
    await until(lambda: problems == [NOT_YET, None])
    assert [record.levelname for record in caplog.records] == ["WARNING", "WARNING"]
    await writer.close()


async def test_closing_does_not_wait_for_a_disk_that_hangs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, gate = LatchFile(tmp_path / "stops.json"), threading.Event()
    monkeypatch.setattr(file, "write", lambda _: gate.wait(10))
    writer = LatchWriter(file, lambda: None, close_within=0.01)
    writer.put({"/": ADA})
    async with asyncio.timeout(5):
        await writer.close()
    assert writer.problem == NOT_YET
    gate.set()


async def test_closing_waits_for_what_is_being_stored(tmp_path: Path) -> None:
    file = LatchFile(tmp_path / "stops.json")
    writer = LatchWriter(file, lambda: None)
    writer.put({"/": ADA})
    await writer.close()
    assert file.read() == {"/": ADA}

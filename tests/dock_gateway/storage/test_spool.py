"""The spool: on the disk at once, damaged lines left out, taken over from the dead and not from the living."""

import asyncio
import logging
from datetime import UTC, datetime
from pathlib import Path

import pytest

from dock_gateway.core.goal import Goal, GoalError
from dock_gateway.storage.rows import Entry, Key, entry_of, line_of
from dock_gateway.storage.spool import Spool
from tests.support.history import make_event, make_goal


async def everything(spool: Spool) -> list[Entry]:
    paths = await spool.take_over()
    return [entry async for entries in spool.read(paths, 2) for entry in entries]


def files(folder: Path) -> list[Path]:
    return list(folder.glob("*.jsonl"))


def test_entries_survive_their_line() -> None:
    goal = make_goal(1, error=GoalError("code", "why"), result=b'{"x": 1.50}', finished_at=datetime.now(UTC))
    goal.verb = "dock"
    found = entry_of(line_of(goal))
    assert isinstance(found, Goal)
    assert {name: getattr(found, name) for name in Goal.__slots__} == {
        name: getattr(goal, name) for name in Goal.__slots__
    }
    for entry in (make_event(1), make_event(2, "battery", droppable=True), Key("k", "g", "f", datetime.now(UTC))):
        assert entry_of(line_of(entry)) == entry


async def test_what_is_damaged_is_left_out_and_logged(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    first = Spool(tmp_path)
    await first.append([make_event(number) for number in range(5)])
    await first.close()
    (path,) = files(tmp_path)
    lines = path.read_bytes().splitlines(keepends=True)
    lines[1] = lines[1].replace(b"topic", b"tipoc")
    lines[3] = b"\0" * 40 + b"\n"
    path.write_bytes(b"".join([*lines, b"no checksum\n", b"00000000 {}\n", lines[0][:20]]))
    (tmp_path / "2.jsonl").write_bytes(b"")
    second = Spool(tmp_path)
    with caplog.at_level(logging.ERROR):
        assert await everything(second) == [make_event(0), make_event(2), make_event(4)]
    assert caplog.text.count("is damaged and skipped") == 5
    await second.close()


async def test_the_spool_of_the_living_is_left_alone(tmp_path: Path) -> None:
    living, other = Spool(tmp_path), Spool(tmp_path)
    await living.append([make_event(1)])
    assert await everything(other) == []
    await living.close()
    assert await everything(other) == [make_event(1)]
    assert other.count == 1
    await other.remove(await other.rotate())
    assert other.count == 0
    assert files(tmp_path) == []
    await other.close()


async def test_a_disk_that_takes_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    spool = Spool(tmp_path / "file" / "spool")
    assert await everything(spool) == []
    with pytest.raises(OSError, match="Not a directory"):
        await spool.append([make_event(1)])
    await spool.close()


async def test_many_at_once(tmp_path: Path) -> None:
    spool, other = Spool(tmp_path), Spool(tmp_path)
    await asyncio.gather(*(spool.append([make_event(number)]) for number in range(50)))
    assert spool.count == 50
    await spool.close()
    assert await everything(other) == [make_event(number) for number in range(50)]
    await other.close()

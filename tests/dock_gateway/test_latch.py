"""The rules of latched stops, and the file that keeps them."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from dock_gateway.latch import Latch, Latches, LatchFile

ADA = Latch(datetime(2026, 11, 21, 3, 32, 40, 123456, UTC), "Ada")
BOB = Latch(datetime(2026, 11, 21, 4, 0, 0, 0, UTC), "Bob")


def test_a_stop_holds_for_what_is_below() -> None:
    latches = Latches({"/fleet": ADA})
    assert latches.over("/fleet/robot1/dock") == "/fleet"
    assert latches.over("/dock") is None
    assert latches.document("/", ["/", "/fleet/robot1", "/robot2"]) == {
        "latched": False,
        "since": None,
        "by": None,
        "robots": ["/fleet/robot1"],
    }
    assert latches.document("/fleet/robot1", ["/", "/fleet/robot1"]) == {
        "latched": True,
        "since": ADA.since,
        "by": "Ada",
        "robots": ["/fleet/robot1"],
    }


def test_the_first_who_stopped_it_is_named() -> None:
    latches = Latches({"/": ADA})
    latches.latch("/", BOB)
    assert latches.held == {"/": ADA}
    latches.release("/")
    latches.release("/")
    assert latches.held == {}


def test_the_file_gives_back_what_was_written(tmp_path: Path) -> None:
    file = LatchFile(tmp_path / "data" / "stops.json")
    assert file.read("/") == {}
    file.write({"/": ADA, "/robot1": Latch(BOB.since)})
    assert LatchFile(file.path).read("/") == {"/": ADA, "/robot1": Latch(BOB.since)}
    file.write({})
    assert file.read("/") == {}
    assert [path.name for path in file.path.parent.iterdir()] == ["stops.json"]


@pytest.mark.parametrize("content", [b"", b"[]", b'{"/": {}}', b'{"/": {"since": 1, "by": null}}', b"\xff"])
def test_a_file_that_cannot_be_read_releases_nothing(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "stops.json"
    path.write_bytes(content)
    assert list(LatchFile(path).read("/robot1")) == ["/robot1"]


def test_a_disk_that_does_not_take_it_says_so(tmp_path: Path) -> None:
    (tmp_path / "stops.json").mkdir()
    with pytest.raises(OSError, match=r"stops\.json"):
        LatchFile(tmp_path / "stops.json").write({"/": ADA})
    assert [path.name for path in tmp_path.iterdir()] == ["stops.json"]

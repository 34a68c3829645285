"""Labels as the histories store them; tests/dock_gateway/storage/test_shared_entries.py has acknowledgements."""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path

import pytest
from pydantic import BaseModel

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.fleet.alert import Acknowledgement
from dock_gateway.robots.labels import RobotLabel
from dock_gateway.storage import Entries, History
from tests.support.history import locked, open_place
from tests.support.waiting import until

AT = datetime(2026, 1, 1, 12, 0, 0, 123456, tzinfo=UTC)
LEFT = RobotLabel("Left forklift", ("hall 1", "Gabelstapler ü, \"'"))
RIGHT = RobotLabel(None, ("hall 1",))
BARE = RobotLabel("Bar\u00e9", ())


@asynccontextmanager
async def opened(url: str, folder: Path) -> AsyncIterator[History]:
    async with open_place(url, folder) as history:
        await until(lambda: history.stats().database_reachable)
        yield history


def labels_of(history: History) -> Entries[RobotLabel]:
    return history.documents("label", RobotLabel)


async def labels_in(history: History) -> dict[str, RobotLabel]:
    """All labels, once the database answers."""
    for _ in range(200):
        try:
            return await labels_of(history).read()
        except Unavailable:
            await asyncio.sleep(0.05)
    raise AssertionError("they cannot be read")


def is_free(name: str) -> Callable[[Mapping[str, RobotLabel]], None]:
    def check(labels: Mapping[str, RobotLabel]) -> None:
        if any(label.display_name == name for label in labels.values()):
            raise Conflict("taken", code="display_name_taken")

    return check


@pytest.mark.usefixtures("patient")
async def test_labels_are_stored_replaced_and_removed(place: str, tmp_path: Path) -> None:
    async with opened(place, tmp_path) as history:
        assert await labels_in(history) == {}
        await labels_of(history).write("/robot1", LEFT)
        await labels_of(history).write("/robot1", BARE)
        await labels_of(history).write("/robot2", LEFT)
        await labels_of(history).write("/robot3", RIGHT)
        await labels_of(history).write("/robot3", None)
        await labels_of(history).write("/never", None)
        assert await labels_in(history) == {"/robot1": BARE, "/robot2": LEFT}
        assert await history.documents("acknowledgement", Acknowledgement).read() == {}


class Lamp(BaseModel):
    """A document of this version."""

    name: str
    lit_at: datetime | None = None
    colours: tuple[str, ...] = ()


class LaterLamp(Lamp):
    """One of a later version, which has a new field."""

    watts: float = 60.0


@pytest.mark.usefixtures("patient")
async def test_documents_are_what_they_were(place: str, tmp_path: Path) -> None:
    red, dark = Lamp(name="Lämpchen", lit_at=AT, colours=("red", "\"'")), Lamp(name="Lamp")
    async with opened(place, tmp_path) as history:
        lamps, others = history.documents("lamp", Lamp), history.documents("other", Lamp)
        for lamp_id, lamp in (("a", dark), ("a", red), ("b", dark), ("c", red)):
            await lamps.write(lamp_id, lamp)
        await lamps.write("c", None)
        await others.write("a", dark)
        assert await lamps.read() == {"a": red, "b": dark}
        assert await history.documents("other", Lamp).read() == {"a": dark}


@pytest.mark.usefixtures("patient")
async def test_a_new_field_has_its_default_in_older_documents_and_older_gateways_do_without_it(
    database_url: str, tmp_path: Path
) -> None:
    async with opened(database_url, tmp_path) as history:
        older, later = history.documents("lamp", Lamp), history.documents("lamp", LaterLamp)
        await older.write("a", Lamp(name="Lamp"))
        await later.write("b", LaterLamp(name="Lamp", watts=5))
        assert await later.read() == {"a": LaterLamp(name="Lamp"), "b": LaterLamp(name="Lamp", watts=5)}
        assert await older.read() == {"a": Lamp(name="Lamp"), "b": Lamp(name="Lamp")}


class State(StrEnum):
    """A field of a document."""

    PENDING = "pending"
    DELIVERED = "delivered"


@dataclass(frozen=True)
class Parcel:
    """A document that is a dataclass."""

    state: State
    at: datetime
    body: bytes
    attempts: int
    weight: float | None
    detail: str | None
    open: bool


@pytest.mark.usefixtures("patient")
async def test_dataclasses_are_what_they_were(place: str, tmp_path: Path) -> None:
    sent = Parcel(State.DELIVERED, AT, b'{"text":"\xc3\xbc","n":1.0}', 2, 0.1, "why", open=True)
    new = Parcel(State.PENDING, AT, b"{}", 0, None, None, open=False)
    async with opened(place, tmp_path) as history:
        parcels = history.documents("parcel", Parcel)
        for identity, parcel in (("1", new), ("1", sent), ("2", new)):
            await parcels.write(identity, parcel)
        found = await parcels.read()
        assert found == {"1": sent, "2": new}
        assert isinstance(found["1"].state, State)


@pytest.mark.usefixtures("patient")
async def test_a_label_that_is_refused_is_not_stored(place: str, tmp_path: Path) -> None:
    async with opened(place, tmp_path) as history:
        await labels_of(history).write("/robot1", LEFT, is_free("Left forklift"))
        with pytest.raises(Conflict):
            await labels_of(history).write("/robot2", LEFT, is_free("Left forklift"))
        await labels_of(history).write("/robot2", RIGHT, is_free("anything else"))
        assert await labels_in(history) == {"/robot1": LEFT, "/robot2": RIGHT}


@pytest.mark.usefixtures("patient")
async def test_they_outlive_a_restart(database_url: str, tmp_path: Path) -> None:
    async with opened(database_url, tmp_path) as history:
        await labels_of(history).write("/robot1", LEFT)
    async with opened(database_url, tmp_path) as history:
        assert await labels_in(history) == {"/robot1": LEFT}


@pytest.mark.usefixtures("patient")
async def test_of_two_gateways_at_the_same_time_one_gets_the_name(database_url: str, tmp_path: Path) -> None:
    async with opened(database_url, tmp_path / "a") as one, opened(database_url, tmp_path / "b") as other:
        for number in range(10):
            label = RobotLabel(f"Forklift {number}", ())
            check = is_free(f"Forklift {number}")
            ends = await asyncio.gather(
                labels_of(one).write(f"/a{number}", label, check),
                labels_of(other).write(f"/b{number}", label, check),
                return_exceptions=True,
            )
            assert sorted(type(end) for end in ends if end is not None) == [Conflict]
        names = [label.display_name for label in (await labels_in(one)).values()]
        assert sorted(map(str, names)) == [f"Forklift {number}" for number in range(10)]


async def test_a_database_that_is_locked_takes_none(sqlite_url: str, tmp_path: Path) -> None:
    async with opened(sqlite_url, tmp_path) as history:
        await labels_of(history).write("/robot1", LEFT)
        with locked(sqlite_url.removeprefix("sqlite:///")):
            with pytest.raises(Unavailable) as refused:
                await labels_of(history).write("/robot1", RIGHT)
            assert refused.value.code == "history_unavailable"
        assert await labels_in(history) == {"/robot1": LEFT}


async def test_after_the_file_was_deleted_they_can_be_set_again(sqlite_url: str, tmp_path: Path) -> None:
    async with opened(sqlite_url, tmp_path) as history:
        await labels_of(history).write("/robot1", LEFT)
        (tmp_path / "history.db").unlink()
        with pytest.raises(Unavailable):
            await labels_of(history).write("/robot1", RIGHT)
        await until(lambda: history.incident is not None and history.stats().database_reachable)
        assert await labels_in(history) == {}
        await labels_of(history).write("/robot1", RIGHT)
        assert await labels_in(history) == {"/robot1": RIGHT}

"""Entries are shared by gateways that share a history, and hold while it is away."""

import asyncio
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from dock_gateway.core.errors import ChangedMeanwhile, NotFound, Unavailable
from dock_gateway.core.versions import Condition
from dock_gateway.fleet.alert import Acknowledgement
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries
from tests.support.entries import SharedStore
from tests.support.history import HistoryInMemory, open_at
from tests.support.waiting import until

NOON = datetime(2026, 1, 1, 12, 0, 0, 123456, tzinfo=UTC)
ADA, BOB = Acknowledgement("Ada", NOON), Acknowledgement("Bo\u0308b", NOON)


async def test_they_are_kept_in_both_databases(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path / "a") as first, open_at(database_url, tmp_path / "b") as second:
        await until(lambda: second.stats().database_reachable)
        here, there = (
            SharedEntries(first.documents("acknowledgement", Acknowledgement)),
            SharedEntries(second.documents("acknowledgement", Acknowledgement)),
        )
        here.put("a", BOB)
        here.put("a", ADA)
        here.put("b", BOB)
        assert await here.sync()
        assert await there.sync()
        assert (there.get("a"), there.get("b"), there.keys()) == (ADA, BOB, {"a", "b"})
        there.put("b", None)
        there.put("never", None)
        await there.save()
        assert await here.sync()
        assert here.keys() == {"a"}
    async with open_at(database_url, tmp_path / "c") as later:
        again = SharedEntries(later.documents("acknowledgement", Acknowledgement))
        assert await again.sync()
        assert again.get("a") == ADA


async def test_they_hold_while_the_history_is_away() -> None:
    store = SharedStore[Acknowledgement]()
    here, there = SharedEntries(store), SharedEntries(store)
    store.away = True
    here.put("a", ADA)
    here.put("b", None)
    await here.save()
    assert not await here.sync()
    assert (here.get("a"), here.unsaved) == (ADA, True)
    store.away = False
    assert await here.sync()
    assert not here.unsaved
    assert await there.sync()
    assert there.get("a") == ADA


async def test_what_is_put_while_others_are_stored_is_not_undone_by_a_read(monkeypatch: pytest.MonkeyPatch) -> None:
    store = SharedStore[Acknowledgement]()
    here = SharedEntries(store)
    write = store.write

    async def write_slowly(key: str, *rest: Any) -> None:
        await write(key, *rest)
        if key == "a":
            here.put("b", BOB)

    monkeypatch.setattr(store, "write", write_slowly)
    here.put("a", ADA)
    assert await here.sync()
    assert (here.get("a"), here.get("b")) == (ADA, BOB)


async def test_what_must_be_stored_first_is_set_then() -> None:
    store = SharedStore[Acknowledgement]()
    here = SharedEntries(store)
    stored: list[Mapping[str, Acknowledgement]] = []
    store.gate.clear()
    reading = asyncio.create_task(here.sync())
    await asyncio.sleep(0)
    await here.store("a", ADA, lambda entries: stored.append(dict(entries)))
    store.gate.set()
    assert await reading
    assert here.get("a") == ADA, "what was read is older"
    store.away = True
    for entry in (BOB, None):
        with pytest.raises(Unavailable):
            await here.store("a", entry, lambda _: None)
    store.away = False
    await here.store("a", None, lambda entries: stored.append(dict(entries)))
    assert (here.get("a"), here.unsaved, await store.read()) == (None, False, {})
    assert stored == [{}, {"a": ADA}]


@pytest.mark.parametrize("put", [BOB, None])
async def test_what_is_put_while_the_same_is_stored_is_kept(
    put: Acknowledgement | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = SharedStore[Acknowledgement]()
    here = SharedEntries(store)
    write = store.write

    async def write_slowly(*what: Any) -> None:
        await write(*what)
        if what[1] is ADA:
            here.put("a", put)

    monkeypatch.setattr(store, "write", write_slowly)
    await here.store("a", ADA, lambda _: None)
    assert here.get("a") == put
    assert await here.sync()
    assert (here.get("a"), (await store.read()).get("a")) == (put, put)


async def test_what_is_stored_is_not_undone_by_what_was_put_before() -> None:
    store = SharedStore[Acknowledgement]()
    here = SharedEntries(store)
    here.put("a", ADA)
    await here.store("a", BOB, lambda _: None)
    assert await here.sync()
    assert (here.get("a"), await store.read()) == (BOB, {"a": BOB})


async def test_what_is_read_meanwhile_does_not_undo_anything() -> None:
    store = SharedStore[Acknowledgement]()
    here = SharedEntries(store)
    store.gate.clear()
    reading = asyncio.create_task(here.sync())
    await asyncio.sleep(0)
    here.put("a", ADA)
    await here.save()
    store.gate.set()
    assert await reading
    assert here.get("a") == ADA
    assert await here.sync()
    assert here.get("a") == ADA


async def test_a_history_in_memory_keeps_them_too() -> None:
    history = HistoryInMemory()
    here, again = (
        SharedEntries(history.documents("acknowledgement", Acknowledgement)),
        SharedEntries(history.documents("acknowledgement", Acknowledgement)),
    )
    here.put("a", ADA)
    assert await here.sync()
    assert await again.sync()
    assert again.get("a") == ADA


async def test_of_two_writes_that_are_based_on_one_version_one_is_made(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path / "a") as first, open_at(database_url, tmp_path / "b") as second:
        await until(lambda: first.stats().database_reachable and second.stats().database_reachable)
        books = [
            SharedBook(each.documents("acknowledgement", Acknowledgement), "acknowledgement", 3)
            for each in (first, second)
        ]
        assert await books[0].replace("a", ADA)
        etag = books[0].etag((await books[1].read())["a"])
        assert etag == books[0].etag(ADA)
        assert etag != books[0].etag(BOB)
        based = Condition(frozenset({str(etag)}))
        for change in (
            lambda book, number: book.replace("a", Acknowledgement(f"{number}", NOON), condition=based),
            lambda book, _: book.remove("a", based),
        ):
            await books[0].replace("a", ADA)
            done = await asyncio.gather(
                *(change(books[number % 2], number) for number in range(6)), return_exceptions=True
            )
            assert sum(not isinstance(each, BaseException) for each in done) == 1
            assert {type(each) for each in done if isinstance(each, BaseException)} <= {ChangedMeanwhile, NotFound}
        news = await asyncio.gather(
            *(books[number % 2].replace("b", BOB, condition=Condition(absent=True)) for number in range(6)),
            return_exceptions=True,
        )
        assert news.count(True) == 1

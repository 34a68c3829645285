"""Alerts are told as they come, end and are acknowledged."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any, cast

import orjson
import pytest

from dock_gateway.core.errors import ChangedMeanwhile, NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.versions import Condition
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert import Acknowledgement, Alert, alert_id
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.storage.shared_entries import SharedEntries
from tests.support.entries import EntriesInMemory
from tests.support.robot_states import robot

LOW, WELL = [robot(percentage=0.1)], [robot(percentage=0.9)]
ID = alert_id(alert_kinds.LOW_BATTERY, "/robot1")


class Scene:
    def __init__(self) -> None:
        self.fanout = Fanout(queue_limit=10)
        self.store = EntriesInMemory[Acknowledgement]()
        self.boards: list[AlertBoard] = []
        self.reader = self.fanout.subscribe(EventFilter(frozenset({"alerts"})))

    def board(self, **timing: float) -> AlertBoard:
        entries = SharedEntries(self.store)
        self.boards.append(AlertBoard(self.fanout, entries, low_battery=0.2, sync_interval=0.01, **timing))
        return self.boards[-1]


@pytest.fixture
async def scene() -> AsyncIterator[Scene]:
    scene = Scene()
    yield scene
    for board in scene.boards:
        await board.close()


async def told(subscriber: Subscriber) -> list[list[tuple[str, str | None]]]:
    """Of each event, the kinds of alerts and who has acknowledged them."""
    events, _ = await subscriber.take(0.01)
    documents = [orjson.loads(event.data) for event in events]
    assert all(document["type"] == "alerts" for document in documents)
    return [
        [(alert["kind"], (alert["acknowledged"] or {}).get("by")) for alert in document["alerts"]]
        for document in documents
    ]


def acknowledged(board: AlertBoard) -> Any:
    (document,) = board.documents()
    return document["acknowledged"]


async def until_acknowledged(board: AlertBoard, by: str | None) -> None:
    for _ in range(200):
        if (acknowledged(board).by if acknowledged(board) else None) == by:
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"not acknowledged by {by}: {board.documents()}")


async def test_alerts_are_told_when_they_change(scene: Scene) -> None:
    board = scene.board()
    board.update(WELL, [])
    assert await told(scene.reader) == [[]]
    board.update(LOW, [])
    board.update(LOW, [])
    assert await told(scene.reader) == [[("low_battery", None)]]
    document = await board.acknowledge(ID, "Ada")
    assert document["acknowledged"].by == "Ada"
    assert await told(scene.reader) == [[("low_battery", "Ada")]]
    assert (await board.acknowledge(ID, None))["acknowledged"] is None
    assert await told(scene.reader) == [[("low_battery", None)]]
    board.update(WELL, [])
    assert await told(scene.reader) == [[]]
    for change in (board.acknowledge(ID, "Ada"), board.acknowledge(ID, None)):
        with pytest.raises(NotFound) as refused:
            await change
        assert refused.value.code == "alert_not_found"


async def test_an_alert_that_comes_back_is_not_acknowledged(scene: Scene) -> None:
    board = scene.board()
    board.update(LOW, [])
    await board.acknowledge(ID, "Ada")
    board.update(WELL, [])
    board.update(LOW, [])
    assert acknowledged(board) is None
    await asyncio.sleep(0.05)
    assert acknowledged(board) is None
    assert await scene.store.read() == {}


async def test_another_gateway_hears_of_it(scene: Scene) -> None:
    one, other = scene.board(), scene.board()
    for board in (one, other):
        board.update(LOW, [])
    await one.acknowledge(ID, "Ada")
    await until_acknowledged(other, "Ada")
    other.update(LOW, [])
    assert (await told(scene.reader))[-1] == [("low_battery", "Ada")]
    await other.acknowledge(ID, None)
    await until_acknowledged(one, None)


async def test_after_a_restart_it_holds_where_the_alert_does(scene: Scene) -> None:
    await scene.store.write(ID, Acknowledgement("Ada", utc_now()))
    await scene.store.write("over", Acknowledgement("Bob", utc_now()))
    board = scene.board(settled_after=0.2)
    await asyncio.sleep(0.05)
    assert len(await scene.store.read()) == 2
    board.update(LOW, [])
    assert acknowledged(board).by == "Ada"
    for _ in range(200):
        if list(await scene.store.read()) == [ID]:
            break
        await asyncio.sleep(0.01)
    assert list(await scene.store.read()) == [ID]


async def test_a_source_that_fails_hides_no_other_alert(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    board = scene.board()
    sources = [lambda: [Alert(alert_kinds.EXTENSION_FAILED, None, utc_now(), "No maps", "")], lambda: [1 / 0]]
    for source in (*sources, sources[0]):
        board.sources.append(cast("Any", source))
    for _ in range(3):
        board.update(LOW, [])
    assert {document["kind"] for document in board.documents()} == {"low_battery", "extension_failed"}
    assert caplog.text.count("alerts cannot be read") == 1


async def test_of_two_people_who_acknowledge_one_version_one_does(scene: Scene) -> None:
    board = scene.board()
    board.update(LOW, [])
    seen = Condition(frozenset({board.document(ID)["etag"]}))
    mine = await board.acknowledge(ID, "Ada", seen)
    for by in ("Bob", None):
        with pytest.raises(ChangedMeanwhile):
            await board.acknowledge(ID, by, seen)
    assert board.document(ID) == mine
    assert (await board.acknowledge(ID, None, Condition(frozenset({mine["etag"]}))))["acknowledged"] is None

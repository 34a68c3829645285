"""Alerts are told as they come, end and are acknowledged."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import orjson
import pytest

from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.hub import Hub, Subscriber
from dock_gateway.fleet import alerts as alarm_module
from dock_gateway.fleet.alert_rules import AlertKind, alert_id
from dock_gateway.fleet.alerts import Acknowledgements, AlertBoard
from dock_gateway.history import Acknowledgement
from dock_gateway.history.memory import MemoryAcknowledgements
from tests.dock_gateway.fleet.test_alert_rules import robot

LOW, WELL = [robot(percentage=0.1)], [robot(percentage=0.9)]
ID = alert_id(AlertKind.LOW_BATTERY, "/robot1")


class Scene:
    def __init__(self) -> None:
        self.hub = Hub(queue_limit=10, max_subscribers=10)
        self.store = MemoryAcknowledgements()
        self.alarms: list[AlertBoard] = []
        self.reader = self.hub.subscribe(EventFilter(frozenset({"robots"})))

    def alarm(self) -> AlertBoard:
        self.alarms.append(AlertBoard(self.hub, Acknowledgements(self.store), low_battery=0.2))
        return self.alarms[-1]


@pytest.fixture
async def scene(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Scene]:
    monkeypatch.setattr(alarm_module, "SYNC_INTERVAL", 0.01)
    scene = Scene()
    yield scene
    for alarm in scene.alarms:
        await alarm.close()


async def told(subscriber: Subscriber) -> list[list[tuple[str, str | None]]]:
    """Of each event, the kinds of alerts and who has acknowledged them."""
    events, _ = await subscriber.take(0.01)
    documents = [orjson.loads(event.data) for event in events]
    assert all(document["type"] == "alerts" for document in documents)
    return [
        [(alert["kind"], (alert["acknowledged"] or {}).get("by")) for alert in document["alerts"]]
        for document in documents
    ]


def acknowledged(alarm: AlertBoard) -> Any:
    (document,) = alarm.documents()
    return document["acknowledged"]


async def until_acknowledged(alarm: AlertBoard, by: str | None) -> None:
    for _ in range(200):
        if (acknowledged(alarm).by if acknowledged(alarm) else None) == by:
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"not acknowledged by {by}: {alarm.documents()}")


async def test_alerts_are_told_when_they_change(scene: Scene) -> None:
    alarm = scene.alarm()
    alarm.look(WELL, [])
    assert await told(scene.reader) == [[]]
    alarm.look(LOW, [])
    alarm.look(LOW, [])
    assert await told(scene.reader) == [[("low_battery", None)]]
    document = await alarm.acknowledge(ID, "Ada")
    assert document["acknowledged"].by == "Ada"
    assert await told(scene.reader) == [[("low_battery", "Ada")]]
    assert (await alarm.withdraw(ID))["acknowledged"] is None
    assert await told(scene.reader) == [[("low_battery", None)]]
    alarm.look(WELL, [])
    assert await told(scene.reader) == [[]]
    for change in (alarm.acknowledge(ID, "Ada"), alarm.withdraw(ID)):
        with pytest.raises(NotFound) as refused:
            await change
        assert refused.value.code == "alert_not_found"


async def test_an_alert_that_comes_back_is_not_acknowledged(scene: Scene) -> None:
    alarm = scene.alarm()
    alarm.look(LOW, [])
    await alarm.acknowledge(ID, "Ada")
    alarm.look(WELL, [])
    alarm.look(LOW, [])
    assert acknowledged(alarm) is None
    await asyncio.sleep(0.05)
    assert acknowledged(alarm) is None
    assert await scene.store.read() == {}


async def test_another_gateway_hears_of_it(scene: Scene) -> None:
    one, other = scene.alarm(), scene.alarm()
    for alarm in (one, other):
        alarm.look(LOW, [])
    await one.acknowledge(ID, "Ada")
    await until_acknowledged(other, "Ada")
    other.look(LOW, [])
    assert (await told(scene.reader))[-1] == [("low_battery", "Ada")]
    await other.withdraw(ID)
    await until_acknowledged(one, None)


async def test_after_a_restart_it_holds_where_the_alert_does(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    await scene.store.write(ID, Acknowledgement("Ada", utc_now()))
    await scene.store.write("over", Acknowledgement("Bob", utc_now()))
    monkeypatch.setattr(alarm_module, "SETTLED_AFTER", 0.2)
    alarm = scene.alarm()
    await asyncio.sleep(0.05)
    assert len(await scene.store.read()) == 2
    alarm.look(LOW, [])
    assert acknowledged(alarm).by == "Ada"
    for _ in range(200):
        if list(await scene.store.read()) == [ID]:
            break
        await asyncio.sleep(0.01)
    assert list(await scene.store.read()) == [ID]

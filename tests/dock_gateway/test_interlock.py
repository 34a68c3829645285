"""Who is told of a latched stop, and what two gateways make of it. The topic is a fake; tests/system has a real one."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import orjson
import pytest

from dock_gateway import interlock as interlock_module
from dock_gateway.errors import Conflict
from dock_gateway.hub import Hub
from dock_gateway.interest import Interest
from dock_gateway.interlock import Interlock
from dock_gateway.latch import LatchFile


class FakeTopic:
    """`stop_latched` of one robot, between gateways."""

    def __init__(self) -> None:
        self.said: list[bool | None] = []
        self.others: list[Interlock] = []

    async def publish(self, *, latched: bool) -> None:
        self.said.append(latched)
        for other in self.others:
            asyncio.get_running_loop().call_soon(lambda to=other: to.heard("/", latched=latched))

    async def withdraw(self) -> None:
        self.said.append(None)


class Gateway:
    def __init__(self, path: Path) -> None:
        self.hub = Hub(queue_limit=10, max_subscribers=10)
        self.reader = self.hub.subscribe(Interest(frozenset({"system"})))
        self.interlock = Interlock(self.hub, LatchFile(path), "/")
        self.topic = FakeTopic()
        self.interlock.join("/", self.topic)

    async def events(self) -> list[dict[str, Any]]:
        return [orjson.loads(event.data) for event in (await self.reader.take(1.0))[0]]


@pytest.fixture
async def pair(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[tuple[Gateway, Gateway]]:
    monkeypatch.setattr(interlock_module, "ECHO_AFTER", 0.02)
    first, second = Gateway(tmp_path / "first.json"), Gateway(tmp_path / "second.json")
    first.topic.others, second.topic.others = [second.interlock], [first.interlock]
    yield first, second
    await first.interlock.close()
    await second.interlock.close()


async def settle() -> None:
    await asyncio.sleep(0.1)


async def test_goals_are_refused_until_the_stop_is_released(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    interlock.require_released("/dock")
    await interlock.latch("/", "Ada")
    for name in ("/dock", "/robot1/dock"):
        with pytest.raises(Conflict, match="stopped by Ada") as refused:
            interlock.require_released(name)
        assert refused.value.code == "stop_latched"
    event = (await pair[0].events())[0]
    assert (event["type"], event["robot"], event["stop"]["latched"], event["stop"]["by"]) == ("stop", "/", True, "Ada")
    await interlock.release("/")
    interlock.require_released("/dock")
    assert [event["stop"]["latched"] for event in await pair[0].events()] == [False]


async def test_a_robot_that_has_left_is_told_nothing(pair: tuple[Gateway, Gateway]) -> None:
    interlock, topic = pair[0].interlock, FakeTopic()
    interlock.join("/robot1", topic)
    interlock.heard("/robot1", latched=True)
    interlock.heard("/robot1", latched=False)
    interlock.leave("/robot1")
    await interlock.latch("/")
    await interlock.tell("/")
    await settle()
    assert topic.said == []
    again = FakeTopic()
    interlock.join("/robot1", again)
    await settle()
    assert again.said == [True], "a stop that came meanwhile holds for it"


async def test_it_is_kept_across_a_restart_and_said_again(pair: tuple[Gateway, Gateway], tmp_path: Path) -> None:
    await pair[0].interlock.latch("/", "Ada")
    again = Gateway(tmp_path / "first.json")
    assert again.interlock.document("/")["by"] == "Ada"
    await settle()
    assert again.topic.said == [True]
    await again.interlock.release("/")
    await again.interlock.close()
    assert LatchFile(tmp_path / "first.json").read("/") == {}


async def test_a_robot_that_appears_below_is_held_too(pair: tuple[Gateway, Gateway]) -> None:
    interlock, topic = pair[0].interlock, FakeTopic()
    await interlock.latch("/")
    await pair[0].events()
    interlock.join("/robot1", topic)
    assert [event["stop"]["robots"] for event in await pair[0].events()] == [["/", "/robot1"]]
    await settle()
    assert topic.said == [True]
    with pytest.raises(Conflict, match="release that") as refused:
        await interlock.release("/robot1")
    assert refused.value.code == "stop_latched"
    await interlock.release("/")
    assert topic.said == [True, False]
    assert not interlock.holds("/robot1")


async def test_a_robot_is_held_again_that_another_gateway_released_below_a_stop(pair: tuple[Gateway, Gateway]) -> None:
    interlock, topic = pair[0].interlock, FakeTopic()
    interlock.join("/robot1", topic)
    await interlock.latch("/", "Ada")
    await interlock.tell("/")
    interlock.heard("/robot1", latched=False)  # by one that knows of this robot alone
    await settle()
    assert topic.said == [True, True]
    assert interlock.document("/")["robots"] == ["/", "/robot1"]
    interlock.heard("/robot1", latched=False)  # by one that released both: in whichever order it is heard
    interlock.heard("/", latched=False)
    await settle()
    assert topic.said == [True, True, None]
    assert not interlock.holds("/robot1")


async def test_another_gateway_learns_it_and_says_it_should_the_first_go(pair: tuple[Gateway, Gateway]) -> None:
    first, second = pair
    await first.interlock.latch("/", "Ada")
    await first.interlock.tell("/")
    await settle()
    assert second.interlock.holds("/dock")
    assert second.interlock.document("/")["by"] is None
    assert second.topic.said == [True]
    await second.interlock.release("/")
    await settle()
    assert not first.interlock.holds("/dock")
    assert first.topic.said == [True, None]  # who comes later hears the release alone


async def test_a_stop_that_crosses_a_release_wins_and_then_there_is_peace(pair: tuple[Gateway, Gateway]) -> None:
    first, second = pair
    for gateway in pair:
        await gateway.interlock.latch("/")
        await gateway.interlock.tell("/")
    await settle()
    await second.interlock.release("/")
    await first.interlock.latch("/")
    first.interlock.heard("/", latched=False)
    second.interlock.heard("/", latched=True)
    await settle()
    assert [gateway.interlock.holds("/") for gateway in pair] == [True, True]
    said = [list(gateway.topic.said) for gateway in pair]
    await settle()
    assert [gateway.topic.said for gateway in pair] == said


async def test_a_disk_that_does_not_take_it_stops_nobody_from_stopping(
    pair: tuple[Gateway, Gateway], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "first.json").mkdir()
    await pair[0].interlock.latch("/")
    assert pair[0].interlock.holds("/")
    assert "a restart would forget it" in caplog.text

"""Who is told of a latched stop, and what two gateways make of it. The topic is a fake; tests/system has a real one."""

import asyncio
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, ClassVar

import orjson
import pytest

from dock_gateway.core.errors import Conflict
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from tests.support.waiting import PATIENCE, until


def hear(interlock: Interlock, namespace: str = "/", *, latched: bool, received: float | None = None) -> None:
    """Another gateway says something, now."""
    interlock.heard(namespace, latched=latched, received=time.monotonic() if received is None else received)


class FakeTopic:
    """`stop_latched` of one robot, between gateways. The next `failures` messages are not taken."""

    def __init__(self) -> None:
        self.said: list[bool | None] = []
        self.holder: str | None = None
        self.others: list[Interlock] = []
        self.failures = 0

    def publish(self, *, latched: bool) -> None:
        if self.failures:
            self.failures -= 1
            raise RuntimeError("ROS does not take it")
        self.said.append(latched)
        for other in self.others:
            asyncio.get_running_loop().call_soon(lambda to=other: hear(to, latched=latched))

    async def withdraw(self) -> None:
        self.said.append(None)

    def held_by(self) -> str | None:
        return self.holder

    def let_go(self) -> None:
        pass


class Gateway:
    all: ClassVar[list["Gateway"]] = []

    def __init__(self, path: Path, **timing: float) -> None:
        self.all.append(self)
        self.file = LatchFile(path)
        self.fanout = Fanout(queue_limit=10)
        self.reader = self.fanout.subscribe(EventFilter(frozenset({"stop"})))
        self.interlock = Interlock(self.fanout, self.file, **{"echo_after": 0.02} | timing)
        self.topic = FakeTopic()
        self.interlock.join("/", self.topic)

    async def events(self) -> list[dict[str, Any]]:
        return [orjson.loads(event.data) for event in (await self.reader.take(1.0))[0]]


@pytest.fixture
async def pair(tmp_path: Path) -> AsyncIterator[tuple[Gateway, Gateway]]:
    first, second = Gateway(tmp_path / "first.json"), Gateway(tmp_path / "second.json")
    first.topic.others, second.topic.others = [second.interlock], [first.interlock]
    yield first, second
    Gateway.all.clear()
    await first.interlock.close()
    await second.interlock.close()


async def settle() -> None:
    """Wait until every topic says what holds."""
    await asyncio.sleep(0.05)
    await until(lambda: all(gateway.interlock.settled for gateway in Gateway.all))
    await asyncio.sleep(0)  # the other hears what was said last


async def test_goals_are_refused_until_the_stop_is_released(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    interlock.require_released("/dock")
    interlock.latch("/", "Ada")
    for name in ("/dock", "/robot1/dock"):
        with pytest.raises(Conflict, match="stopped by Ada") as refused:
            interlock.require_released(name)
        assert refused.value.code == "stop_latched"
    event = (await pair[0].events())[0]
    assert (event["type"], event["robot"], event["stop"]["latched"], event["stop"]["by"]) == ("stop", "/", True, "Ada")
    await interlock.release("/")
    interlock.require_released("/dock")
    assert [event["stop"]["latched"] for event in await pair[0].events()] == [False]


async def test_a_robot_that_has_not_joined_yet_is_held_and_released(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    released: list[str] = []
    interlock.on_release.append(released.append)
    interlock.latch("/robot1")
    assert interlock.holds("/robot1/dock")
    await interlock.release("/robot1")
    assert not interlock.holds("/robot1/dock")
    assert released == ["/robot1"]
    assert pair[0].topic.said == []


async def test_who_watches_is_told_which_robot_an_emergency_stop_holds(pair: tuple[Gateway, Gateway]) -> None:
    held: list[str] = []
    pair[0].interlock.on_latch.append(held.append)
    pair[0].interlock.held_by_another("/", "/e_stop")
    assert held == ["/"]
    assert pair[0].interlock.document("/")["stopped_at"] is not None


async def test_a_robot_that_has_left_is_told_nothing(pair: tuple[Gateway, Gateway]) -> None:
    interlock, topic = pair[0].interlock, FakeTopic()
    interlock.join("/robot1", topic)
    hear(interlock, "/robot1", latched=True)
    hear(interlock, "/robot1", latched=False)
    interlock.leave("/robot1")
    interlock.latch("/")
    interlock.publish("/")
    await settle()
    assert topic.said == []
    again = FakeTopic()
    interlock.join("/robot1", again)
    await settle()
    assert again.said == [True], "a stop that came meanwhile holds for it"


async def test_it_is_kept_across_a_restart_and_said_again(pair: tuple[Gateway, Gateway], tmp_path: Path) -> None:
    pair[0].interlock.latch("/", "Ada")
    assert await pair[0].interlock.stored(10.0) is None
    again = Gateway(tmp_path / "first.json")
    assert again.interlock.document("/")["by"] == "Ada"
    await settle()
    assert again.topic.said == [True]
    await again.interlock.release("/")
    await again.interlock.close()
    assert LatchFile(tmp_path / "first.json").read() == {}


async def test_a_robot_that_appears_below_is_held_too(pair: tuple[Gateway, Gateway]) -> None:
    interlock, topic = pair[0].interlock, FakeTopic()
    interlock.latch("/")
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
    interlock.latch("/", "Ada")
    interlock.publish("/")
    hear(interlock, "/robot1", latched=False)  # by one that knows of this robot alone
    await settle()
    assert topic.said == [True, True]
    assert interlock.document("/")["robots"] == ["/", "/robot1"]
    hear(interlock, "/robot1", latched=False)  # by one that released both: in whichever order it is heard
    hear(interlock, latched=False)
    await settle()
    assert topic.said == [True, True, None]
    assert not interlock.holds("/robot1")


async def test_a_robot_held_from_above_keeps_the_name_when_that_stop_is_released(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    interlock.join("/robot1", FakeTopic())
    interlock.latch("/", "Ada")
    interlock.join("/robot2", FakeTopic())
    interlock.publish("/")
    hear(interlock, "/robot1", latched=False)
    await settle()
    hear(interlock, latched=False)  # by a gateway that knows none of the two
    assert [interlock.requested_by(robot) for robot in ("/", "/robot1", "/robot2")] == [None, "Ada", "Ada"]


async def test_another_gateway_learns_it_and_says_it_should_the_first_go(pair: tuple[Gateway, Gateway]) -> None:
    first, second = pair
    first.interlock.latch("/", "Ada")
    first.interlock.publish("/")
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
        gateway.interlock.latch("/")
        gateway.interlock.publish("/")
    await settle()
    await second.interlock.release("/")
    first.interlock.latch("/")
    hear(first.interlock, latched=False)
    hear(second.interlock, latched=True)
    await settle()
    assert [gateway.interlock.holds("/") for gateway in pair] == [True, True]
    said = [list(gateway.topic.said) for gateway in pair]
    await settle()
    assert [gateway.topic.said for gateway in pair] == said


async def test_a_release_that_came_before_the_stop_was_told_does_not_mean_it(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    before = time.monotonic()
    interlock.latch("/", "Ada")
    hear(interlock, latched=False)  # on its way while the stop was carried out
    assert interlock.holds("/")
    interlock.publish("/")
    hear(interlock, latched=False, received=before)  # and one that waited for the loop
    assert interlock.document("/")["by"] == "Ada"
    await settle()
    hear(interlock, latched=False)
    assert not interlock.holds("/")


@pytest.mark.parametrize("latched", [True, False])
async def test_what_could_not_be_said_is_said_until_it_is(pair: tuple[Gateway, Gateway], latched: bool) -> None:
    interlock, topic = pair[0].interlock, pair[0].topic
    topic.others = []  # who has not heard of the release would say the stop again
    interlock.latch("/")
    if not latched:
        interlock.publish("/")
    said = len(topic.said)
    topic.failures = 3
    if latched:
        interlock.publish("/")
    else:
        await interlock.release("/")
    assert len(topic.said) == said
    await until(lambda: topic.said[said:] == [latched])


@pytest.mark.parametrize(("after", "times"), [(60.0, 1), (0.0, 100)])
async def test_it_is_said_again_to_who_asks_again_but_not_many_times_a_second(
    tmp_path: Path, after: float, times: int
) -> None:
    gateway = Gateway(tmp_path / "stops.json", publish_again_after=after)
    gateway.interlock.latch("/")
    for _ in range(100):
        gateway.interlock.publish("/")
        await asyncio.sleep(0)
    assert gateway.topic.said == [True] * times
    await gateway.interlock.close()


async def test_goals_are_looked_for_once_a_stop_of_another_gateway_is_said_here_too(
    pair: tuple[Gateway, Gateway],
) -> None:
    stopped: list[str] = []
    pair[0].interlock.on_latch.append(stopped.append)
    hear(pair[0].interlock, latched=True)
    await until(lambda: stopped == ["/"])


async def test_a_disk_that_does_not_take_it_stops_nobody_from_stopping_and_is_told(
    pair: tuple[Gateway, Gateway], tmp_path: Path
) -> None:
    (tmp_path / "first.json").mkdir()
    interlock = pair[0].interlock
    interlock.latch("/")
    problem = await interlock.stored(10.0 if interlock.document("/")["persisted"] is False else 0.2)
    assert problem is not None
    assert problem.code == "stop_not_persisted"
    assert interlock.holds("/")
    assert interlock.document("/")["persisted"] is False
    stops = [event["stop"] for event in await pair[0].events()]
    async with asyncio.timeout(PATIENCE):  # a disk may take its time to refuse
        while stops[-1]["persisted"]:
            stops += [event["stop"] for event in await pair[0].events()]
    assert all(stop["latched"] for stop in stops)


async def test_hundreds_of_robots_are_shown_as_fast_as_a_few(tmp_path: Path) -> None:
    gateway = Gateway(tmp_path / "stops.json")
    for number in range(1000):
        gateway.interlock.join(f"/robot{number}", FakeTopic())
    began = time.process_time()
    gateway.interlock.latch("/")
    assert len(gateway.interlock.document("/")["robots"]) == 1001
    await asyncio.sleep(0)  # then it is shown
    assert time.process_time() - began < 1.0
    await gateway.interlock.close()


async def test_a_stop_of_nobody_in_particular_names_nobody(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    interlock.latch("/")
    with pytest.raises(
        Conflict, match=r"^/ was stopped: goals are refused until the stop is released \(DELETE /stop\)$"
    ):
        interlock.require_released("/dock")


async def test_a_robot_is_released_by_itself_though_another_is_held(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    topics = {name: FakeTopic() for name in ("/robot1", "/robot2")}
    for name, topic in topics.items():
        interlock.join(name, topic)
        interlock.latch(name)
    interlock.publish("/robot1")
    assert [topic.said for topic in topics.values()] == [[True], []], "the other one is not told"
    interlock.publish("/robot2")
    await interlock.release("/robot1")
    assert [interlock.holds(name) for name in topics] == [False, True]
    assert [topic.said for topic in topics.values()] == [[True, False], [True]]


async def test_a_release_waits_for_the_disk_only_for_a_while(
    pair: tuple[Gateway, Gateway], monkeypatch: pytest.MonkeyPatch
) -> None:
    interlock, gate = pair[0].interlock, threading.Event()
    interlock.latch("/")
    assert await interlock.stored(10.0) is None
    monkeypatch.setattr(pair[0].file, "write", lambda _: gate.wait(20))
    async with asyncio.timeout(10):
        await interlock.release("/")
    assert interlock.document("/")["persisted"] is False
    gate.set()


async def test_a_stop_of_another_gateway_has_a_time_and_says_the_same_after_a_restart(
    pair: tuple[Gateway, Gateway], tmp_path: Path
) -> None:
    interlock = pair[0].interlock
    hear(interlock, latched=True)
    document = interlock.document("/")
    assert abs((document["stopped_at"] - utc_now()).total_seconds()) < 60
    assert await interlock.stored(10.0) is None
    assert LatchFile(tmp_path / "first.json").read()["/"].stopped_at == document["stopped_at"]


async def test_after_a_release_the_next_release_of_another_gateway_is_heard(pair: tuple[Gateway, Gateway]) -> None:
    first, _ = pair
    first.interlock.latch("/")
    first.interlock.publish("/")
    told = time.monotonic()
    await first.interlock.release("/")
    hear(first.interlock, latched=True)  # a stop of the other one, which it releases in turn
    hear(first.interlock, latched=False, received=told - 60.0)
    assert not first.interlock.holds("/"), "our own stop is over: what was said before it counts again"


async def test_nothing_is_heard_while_it_closes(pair: tuple[Gateway, Gateway]) -> None:
    interlock = pair[0].interlock
    await interlock.close()
    hear(interlock, latched=True)
    assert not interlock.holds("/")


async def test_a_stop_that_comes_while_a_release_is_withdrawn_is_said(
    pair: tuple[Gateway, Gateway], monkeypatch: pytest.MonkeyPatch
) -> None:
    interlock, topic = pair[0].interlock, pair[0].topic
    topic.others = []
    hear(interlock, latched=True)
    await settle()
    withdraw = topic.withdraw

    async def stopped_meanwhile() -> None:
        await withdraw()
        interlock.latch("/")

    monkeypatch.setattr(topic, "withdraw", stopped_meanwhile)
    hear(interlock, latched=False)
    await settle()
    assert topic.said == [True, None, True]


async def test_an_emergency_stop_holds_the_robot_until_it_is_released_there(pair: tuple[Gateway, Gateway]) -> None:
    gateway, _ = pair
    gateway.topic.holder = "/e_stop"
    gateway.interlock.held_by_another("/", "/e_stop")
    assert gateway.interlock.holds("/robot")
    assert gateway.interlock.requested_by("/") == "/e_stop"
    with pytest.raises(Conflict, match="/e_stop holds / stopped") as refused:
        await gateway.interlock.release("/")
    assert refused.value.code == "stop_latched"
    gateway.topic.holder = None
    gateway.interlock.held_by_another("/", None)
    assert not gateway.interlock.holds("/")
    await settle()
    assert gateway.topic.said == []  # the robot hears the emergency stop itself


async def test_the_name_of_who_holds_a_robot_may_become_known_later(pair: tuple[Gateway, Gateway]) -> None:
    gateway, _ = pair
    gateway.interlock.held_by_another("/", "a node on /e_stop")
    since = gateway.interlock.document("/")["stopped_at"]
    gateway.interlock.held_by_another("/", "/scanner")
    document = gateway.interlock.document("/")
    assert (document["by"], document["stopped_at"]) == ("/scanner", since)
    gateway.interlock.latch("/", "Ada")
    gateway.interlock.held_by_another("/", "/other")
    assert gateway.interlock.requested_by("/") == "/scanner"  # it is the stop of a person now


async def test_a_stop_outlasts_that_of_another_node(pair: tuple[Gateway, Gateway]) -> None:
    gateway, _ = pair
    gateway.interlock.held_by_another("/", "/e_stop")
    gateway.interlock.latch("/", "Ada")
    gateway.interlock.held_by_another("/", None)
    assert gateway.interlock.holds("/")
    await gateway.interlock.release("/")
    assert not gateway.interlock.holds("/")


async def test_a_release_at_another_gateway_does_not_overrule_an_emergency_stop(pair: tuple[Gateway, Gateway]) -> None:
    gateway, _ = pair
    gateway.topic.holder = "/e_stop"
    gateway.interlock.held_by_another("/", "/e_stop")
    hear(gateway.interlock, latched=True)
    hear(gateway.interlock, latched=False)
    assert gateway.interlock.holds("/")
    gateway.topic.holder = None
    gateway.interlock.held_by_another("/", None)
    assert gateway.interlock.holds("/")  # until a gateway releases its own
    await gateway.interlock.release("/")
    assert not gateway.interlock.holds("/")


async def test_an_emergency_stop_above_holds_a_robot_below_only_as_long(
    pair: tuple[Gateway, Gateway], tmp_path: Path
) -> None:
    interlock, topic = pair[0].interlock, FakeTopic()
    interlock.held_by_another("/", "/e_stop")
    interlock.join("/robot1", topic)
    interlock.publish("/")
    hear(interlock, "/robot1", latched=True)
    hear(interlock, "/robot1", latched=False)
    await settle()
    assert interlock.requested_by("/robot1/dock") == "/e_stop"
    interlock.held_by_another("/", None)
    assert not interlock.holds("/robot1")
    assert True not in pair[0].topic.said + topic.said
    assert await interlock.stored(10.0) is None
    assert LatchFile(tmp_path / "first.json").read() == {}


@asynccontextmanager
async def two_robots(path: Path) -> AsyncIterator[Interlock]:
    """The latches of a gateway with two robots, none of them in the root."""
    interlock = Interlock(Fanout(queue_limit=10), LatchFile(path), echo_after=0.02)
    for name in ("/robot1", "/robot2"):
        interlock.join(name, FakeTopic())
    yield interlock
    await interlock.close()


async def test_one_robot_is_released_of_a_stop_of_all_and_nothing_else(tmp_path: Path) -> None:
    async with two_robots(tmp_path / "stops.json") as interlock:
        interlock.latch("/", "Ada")
        await interlock.release("/robot1")
        assert not interlock.holds("/robot1/dock")
        held = ("/robot2/dock", "/robot3/dock", "/fibonacci", "/arm/move")
        assert all(interlock.holds(name) for name in held)
        interlock.join("/robot3", FakeTopic())
        assert (interlock.document("/")["latched"], interlock.document("/")["robots"]) == (True, ["/robot2", "/robot3"])
    async with two_robots(tmp_path / "stops.json") as again:
        assert not again.holds("/robot1/dock")
        assert all(again.holds(name) for name in held)
        again.latch("/")
        assert again.holds("/robot1/dock")


async def test_a_stop_of_all_ends_with_the_release_of_the_last_robot(tmp_path: Path) -> None:
    async with two_robots(tmp_path / "stops.json") as interlock:
        interlock.latch("/")
        await interlock.release("/robot1")
        assert interlock.holds("/fibonacci")
        await interlock.release("/robot2")
        assert interlock.document("/")["latched"] is False
        assert not interlock.holds("/fibonacci")


async def test_a_robot_that_was_released_can_be_stopped_and_released_again(tmp_path: Path) -> None:
    async with two_robots(tmp_path / "stops.json") as interlock:
        interlock.latch("/", "Ada")
        await interlock.release("/robot1")
        interlock.latch("/robot1", "Bob")
        assert interlock.requested_by("/robot1") == "Bob"
        await interlock.release("/robot1")
        assert (interlock.holds("/robot1"), interlock.holds("/robot2")) == (False, True)
        await interlock.release("/")
        assert not any(map(interlock.holds, ("/", "/robot1", "/robot2", "/robot3")))

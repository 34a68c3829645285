"""Stops and releases at two gateways in any order, with late messages: a stop that comes last holds, everywhere."""

import asyncio
import tempfile
import time
from collections import deque
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from dock_gateway.core.fanout import Fanout
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from tests.support.waiting import until

ECHO = 0.01


class SlowTopic:
    """`stop_latched` between gateways. What is published arrives in its order, when the test says so."""

    def __init__(self) -> None:
        self.under_way: deque[bool] = deque()
        self.to: Interlock | None = None

    def publish(self, *, latched: bool) -> None:
        self.under_way.append(latched)

    async def withdraw(self) -> None:
        await asyncio.sleep(0)

    def held_by(self) -> str | None:
        return None

    def let_go(self) -> None:
        pass

    def deliver(self) -> None:
        if self.under_way and self.to is not None:
            self.to.heard("/", latched=self.under_way.popleft(), received=time.monotonic())


class Gateway:
    def __init__(self, path: Path) -> None:
        self.path, self.topic = path, SlowTopic()
        self.interlock = Interlock(Fanout(queue_limit=10), LatchFile(path), echo_after=ECHO)
        self.interlock.join("/", self.topic)
        self.releases: set[asyncio.Task[Any]] = set()

    def stop(self) -> None:
        self.interlock.latch("/", "Ada")
        assert self.interlock.holds("/")

    def release(self) -> None:
        self.releases.add(asyncio.create_task(self.interlock.release("/")))


STEPS = st.lists(
    st.tuples(st.sampled_from(["stop", "publish", "release", "deliver", "turn", "echo"]), st.integers(0, 1)),
    max_size=25,
)


async def take(step: str, gateway: Gateway) -> None:
    match step:
        case "stop":
            gateway.stop()
        case "publish":
            gateway.interlock.publish("/")
        case "release":
            gateway.release()
        case "deliver":
            gateway.topic.deliver()
        case "turn":
            await asyncio.sleep(0)
        case _:
            await asyncio.sleep(1.5 * ECHO)


async def play(folder: Path, steps: list[tuple[str, int]], last: str) -> None:
    first, second = pair = Gateway(folder / "first.json"), Gateway(folder / "second.json")
    first.topic.to, second.topic.to = second.interlock, first.interlock
    for step, number in steps:
        await take(step, pair[number])
    await asyncio.sleep(0)  # a release that was asked for has begun
    if last == "stop":
        first.stop()
    else:
        await first.interlock.release("/")
    for gateway in pair:  # each stop is published a moment after it is latched
        gateway.interlock.publish("/")

    def at_rest() -> bool:
        for gateway in pair:
            gateway.topic.deliver()
        return not any(gateway.topic.under_way or not gateway.interlock.settled for gateway in pair)

    await until(at_rest)
    await asyncio.gather(*first.releases, *second.releases)
    held = [gateway.interlock.holds("/") for gateway in pair]
    assert held[0] is held[1]
    assert held[0] or last == "release"
    for gateway in pair:
        await gateway.interlock.close()
        assert bool(LatchFile(gateway.path).read()) is held[0]  # and after a restart


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(STEPS, st.sampled_from(["stop", "release"]))
# A robot that is held is stopped again while a release of the first stop is under way.
@example([("stop", 0), ("publish", 0), ("release", 1), ("deliver", 0)], "stop")
def test_a_stop_that_comes_last_holds_at_both_gateways_and_after_a_restart(
    steps: list[tuple[str, int]], last: str
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(play(Path(folder), steps, last))

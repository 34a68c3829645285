"""An action server that does not answer through one DDS participant is reached through another one."""

import asyncio
import signal
import time
from collections.abc import Iterator

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Json
from dock_gateway.ros.action_port import ActionKind, ActionPort
from dock_gateway.ros.bridge import MAX_BRANCHES, Bridge
from tests.support.gateway import running_program
from tests.support.processes import Process
from tests.support.rejoining import lose_answers
from tests.support.waiting import PATIENCE, until

pytestmark = pytest.mark.ros

A = "aaaaaaaa-0000-4000-8000-000000000000"


@pytest.fixture
def server(domain: int) -> Iterator[Process]:
    """Takes 18 s for a goal, with feedback every 0.4 s."""
    with running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.4") as server:
        yield server


class Heard:
    def __init__(self) -> None:
        self.stamps: list[int] = []

    def feedback(self, _: str, __: Json, stamp_ns: int) -> None:
        self.stamps.append(stamp_ns)


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
async def port(bridge: Bridge, server: Process, heard: Heard) -> ActionPort:
    """The action, whose server answers."""
    kind = ActionKind("action_tutorials_interfaces/action/Fibonacci")
    port = await bridge.call(lambda: ActionPort(bridge, "/fibonacci", kind))
    await bridge.call(lambda: port.listen(lambda *_: None, heard.feedback, lambda *_: None))
    deadline = time.monotonic() + 60
    while not await port.ping(1.0):
        assert time.monotonic() < deadline
        await asyncio.sleep(0.1)
    return port


async def start_goal(port: ActionPort, heard: Heard) -> None:
    call = port.send(A, port.goal_codec.parse({"order": 46}))
    assert (await asyncio.wait_for(call.response, PATIENCE)).accepted
    await until(lambda: bool(heard.stamps))


async def test_a_server_that_answers_elsewhere_is_reached_there(
    bridge: Bridge, port: ActionPort, heard: Heard, monkeypatch: pytest.MonkeyPatch
) -> None:
    await start_goal(port, heard)
    assert (port.unanswered_since, port.answered) == (None, True)
    with monkeypatch.context() as patch:
        lose_answers(bridge, patch)
        assert not await port.ping(0.2)
        assert port.unanswered_since is not None
        cancel = asyncio.create_task(port.cancel(A, timeout=60))
        assert await port.rejoin(60)
        assert port.away
        await cancel  # it was asked again through the new participant
        assert port.unanswered_since is None
        assert not await port.go_home()
        assert port.away
    assert await port.go_home()
    assert not port.away
    assert await port.ping(5)
    await until(lambda: not bridge.branches)
    assert len(set(heard.stamps)) == len(heard.stamps)


async def test_a_second_outage_brings_it_back_to_the_common_participant(
    bridge: Bridge, port: ActionPort, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        lose_answers(bridge, patch)
        assert not await port.ping(0.2)
        assert await port.rejoin(60)
    lose_answers(bridge.branches[0], monkeypatch)
    assert not await port.ping(0.2)
    assert await port.rejoin(60)
    assert not port.away
    await until(lambda: not bridge.branches)


async def test_goals_are_heard_through_the_other_participant(
    bridge: Bridge, port: ActionPort, heard: Heard, monkeypatch: pytest.MonkeyPatch
) -> None:
    await start_goal(port, heard)
    lose_answers(bridge, monkeypatch)
    assert not await port.ping(0.2)
    assert await port.rejoin(60)
    before = len(heard.stamps)
    await until(lambda: len(heard.stamps) > before + 5)
    assert sorted(set(heard.stamps)) == heard.stamps
    await bridge.call(port.close)
    await until(lambda: not bridge.branches)


async def test_a_server_that_answers_stays_where_it_is(bridge: Bridge, port: ActionPort) -> None:
    assert not await port.rejoin(60)
    assert not port.away
    await until(lambda: not bridge.branches)


async def test_a_server_that_answers_nowhere_stays_where_it_is(
    bridge: Bridge, port: ActionPort, server: Process
) -> None:
    server.send_signal(signal.SIGSTOP)
    assert not await port.ping(0.2)
    assert not await port.rejoin(1)
    assert not port.away
    server.send_signal(signal.SIGCONT)
    assert await port.ping(10)


async def test_a_try_that_is_canceled_leaves_nothing_behind(bridge: Bridge, port: ActionPort, server: Process) -> None:
    server.send_signal(signal.SIGSTOP)
    assert not await port.ping(0.2)
    trying = asyncio.create_task(port.rejoin(60))
    await until(lambda: bool(bridge.branches))
    trying.cancel()
    with pytest.raises(asyncio.CancelledError):
        await trying
    await until(lambda: not bridge.branches)


async def test_participants_are_shared_and_limited(bridge: Bridge) -> None:
    """Every robot has an outage at once, or one after the other."""
    before = time.monotonic()
    first, same = await asyncio.gather(bridge.branch(before), bridge.branch(before))
    assert first is same
    others = [await bridge.branch(time.monotonic()) for _ in range(MAX_BRANCHES)]
    assert len({first, *others}) == MAX_BRANCHES
    assert others[-1] is others[-2], "the newest"
    for branch in (first, *others):
        bridge.release(branch)
    assert bridge.branches == [first]
    bridge.release(first)
    assert bridge.branches == []
    bridge.release(bridge)
    assert bridge.alive


async def test_a_request_that_waits_for_the_servers_of_an_action_that_is_left_is_told(
    port: ActionPort, bridge: Bridge
) -> None:
    port.close()
    await bridge.call(lambda: None)
    with pytest.raises(Unavailable) as refused:
        await port.presence()
    assert refused.value.code == "action_server_unavailable"

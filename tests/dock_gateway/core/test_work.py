"""Where work is done that takes long, and what happens when too much waits or the process ends."""

import asyncio
import os
import threading
import time
from collections.abc import AsyncIterator, Callable

import pytest

from dock_gateway.core import work as core_work
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.work import MEDIUM, MOST, MOST_WAITING, SMALL, TURN, Lane, TooLarge, Work, in_turns
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.timeout(PATIENCE)


@pytest.fixture
async def work() -> AsyncIterator[Work]:
    made = Work()
    yield made
    await made.close()


@pytest.fixture
async def lane() -> AsyncIterator[Lane]:
    made = Lane()
    yield made
    await made.close()


def where() -> tuple[int, int]:
    return os.getpid(), threading.get_ident()


@pytest.mark.parametrize(
    ("size", "process", "thread"),
    [(0, True, True), (SMALL, True, True), (SMALL + 1, True, False), (MEDIUM, True, False), (MEDIUM + 1, False, False)],
)
async def test_the_size_says_where(work: Work, size: int, process: bool, thread: bool) -> None:
    pid, ident = await work(size, where)
    assert (pid == os.getpid()) is process
    assert ((pid, ident) == (os.getpid(), threading.get_ident())) is thread


async def test_what_is_too_large_is_refused_with_a_sentence(work: Work) -> None:
    with pytest.raises(TooLarge, match=r"a message of 30\.0 MB is too large: at most 20 MB are read"):
        await work(30_000_000, where)
    assert await work(MOST, where)


async def test_an_error_of_the_process_keeps_its_text(work: Work) -> None:
    with pytest.raises(RuntimeError, match="invalid literal for int"):
        await work(MOST, int, "none")
    assert await work(MOST, int, "7") == 7


async def test_a_large_result_comes_whole_while_others_go_on(work: Work) -> None:
    turns = 0

    async def count() -> None:
        nonlocal turns
        while True:
            await asyncio.sleep(0.001)
            turns += 1

    counting = asyncio.create_task(count())
    assert len(await work(MOST, bytes, 50_000_000)) == 50_000_000
    counting.cancel()
    assert turns


@pytest.mark.parametrize(("end", "args"), [(os._exit, (1,)), (os.abort, ())])
async def test_a_process_that_ends_is_started_again(
    work: Work, end: Callable[..., None], args: tuple[int, ...]
) -> None:
    first, _ = await work(MOST, where)
    with pytest.raises(RuntimeError, match="has ended"):
        await work(MOST, end, *args)
    second, _ = await work(MOST, where)
    assert second != first


async def test_a_process_that_hangs_is_ended(work: Work, monkeypatch: pytest.MonkeyPatch) -> None:
    await work(MOST, where)
    monkeypatch.setattr(core_work, "WITHIN", 0.2)
    with pytest.raises(RuntimeError, match="has ended"):
        await work(MOST, time.sleep, 60)


async def test_closing_does_not_wait_for_the_process(work: Work) -> None:
    pid, _ = await work(MOST, where)
    running = asyncio.create_task(work(MOST, time.sleep, 60))
    await asyncio.sleep(0.1)
    await work.close()
    with pytest.raises(RuntimeError):
        await running
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize("error", [EOFError(), ValueError("the buffer of a closed file"), OSError()])
async def test_however_reading_breaks_when_the_process_is_killed_it_has_ended(
    work: Work, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def load(_: object) -> None:
        raise error

    monkeypatch.setattr(core_work.pickle, "load", load)
    with pytest.raises(RuntimeError, match="has ended"):
        await work(MOST, where)


async def test_the_lane_is_for_one_at_a_time_and_rests_after_each(lane: Lane, monkeypatch: pytest.MonkeyPatch) -> None:
    did: list[str] = []
    monkeypatch.setattr(core_work.time, "sleep", lambda rest: did.append("rest" if rest > 0 else "no rest"))
    monkeypatch.setattr(core_work, "REST", 1000)
    go = threading.Event()

    def compute() -> None:
        go.wait(PATIENCE)
        did.append("begin")
        sum(range(100_000))
        did.append("end")

    working = [asyncio.create_task(lane(compute)) for _ in range(10)]
    await asyncio.sleep(0)  # now all of them wait
    go.set()
    await asyncio.gather(*working)
    assert did == ["begin", "end", *["rest", "begin", "end"] * 9]


async def test_what_waits_has_a_limit(lane: Lane) -> None:
    go = threading.Event()
    waiting = [asyncio.create_task(lane(go.wait, 10)) for _ in range(MOST_WAITING)]
    await asyncio.sleep(0.05)
    with pytest.raises(TooManyRequests, match="too many large messages"):
        await lane(int)
    go.set()
    await asyncio.gather(*waiting)
    assert await lane(int) == 0


async def test_a_long_list_gives_way(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0

    def clock() -> float:
        nonlocal now
        now += TURN / 10
        return now

    monkeypatch.setattr(core_work.time, "perf_counter", clock)
    turns, seen = 0, 0

    def turn() -> None:
        nonlocal turns
        turns += 1
        asyncio.get_running_loop().call_soon(turn)

    turn()
    async for item in in_turns(range(1_000)):
        assert item == seen
        seen += 1
    assert seen == 1_000
    assert 80 <= turns <= 130

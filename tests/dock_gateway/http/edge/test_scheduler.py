"""How the loop's time is shared: at once while there is time, else in turn."""

import asyncio

import pytest

from dock_gateway.http.edge import scheduler as edge_scheduler
from dock_gateway.http.edge.scheduler import TurnScheduler


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time, which only the work takes."""
    now = [0.0]
    monkeypatch.setattr(edge_scheduler, "perf_counter", lambda: now[0])
    return now


async def test_work_is_done_at_once_until_the_turn_is_used_up(clock: list[float]) -> None:
    scheduler = TurnScheduler()
    done = []

    def work() -> None:
        clock[0] += TurnScheduler.TURN / 2
        done.append(len(done))

    for _ in range(2):
        assert scheduler.free
        scheduler.run(work)
    assert not scheduler.free
    await asyncio.sleep(0)
    assert scheduler.free


async def test_what_has_to_wait_is_done_in_turn(clock: list[float]) -> None:
    scheduler = TurnScheduler()
    done: list[tuple[str, int]] = []
    turn = 0

    def work(name: str, times: int) -> None:
        clock[0] += TurnScheduler.TURN / 2
        done.append((name, turn))
        if times > 1:
            scheduler.enqueue(lambda: work(name, times - 1))

    for name in "abc":
        scheduler.enqueue(lambda name=name: work(name, 2))
    assert not scheduler.free
    for turn in range(1, 5):  # noqa: B007 - read by the work
        await asyncio.sleep(0)
    assert done == [("a", 1), ("b", 1), ("c", 2), ("a", 2), ("b", 3), ("c", 3)]
    assert scheduler.free


async def test_work_that_costs_time_elsewhere_is_charged_for_it(clock: list[float]) -> None:
    scheduler = TurnScheduler()
    scheduler.run(lambda: scheduler.charge(TurnScheduler.TURN))
    assert not scheduler.free


async def test_a_task_waits_for_its_turn_and_is_charged_for_it(clock: list[float]) -> None:
    scheduler = TurnScheduler()
    turns: list[int] = []
    turn = 0

    async def wait() -> None:
        await scheduler.wait(TurnScheduler.TURN / 2)
        turns.append(turn)

    tasks = [asyncio.create_task(wait()) for _ in range(6)]
    tasks[2].cancel()
    while len(turns) < 5:
        turn += 1
        await asyncio.sleep(0)
    assert max(turns.count(one) for one in turns) == 2
    assert scheduler.free

"""What comes while a transaction runs goes into the next, once, and each learns how its own ended."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from dock_gateway.core.tasks import cancel
from dock_gateway.storage.group_commit import GroupCommit
from dock_gateway.storage.rows import Batch
from tests.support.history import make_goal


class Store:
    """Stores a batch when the test says so."""

    def __init__(self) -> None:
        self.batches: list[list[str]] = []
        self.results: asyncio.Queue[Exception | None] = asyncio.Queue()

    async def __call__(self, batch: Batch) -> int:
        self.batches.append([goal.goal_id for goal in batch.goals])
        if (error := await self.results.get()) is not None:
            raise error
        return len(self.batches)


@pytest.fixture
def store() -> Store:
    return Store()


@pytest.fixture
async def commits(store: Store) -> AsyncIterator[GroupCommit[int]]:
    commits = GroupCommit(store)
    task = asyncio.create_task(commits.run())
    yield commits
    await cancel(task)


def batch(number: int) -> Batch:
    return Batch(goals=[make_goal(number)])


async def test_what_comes_meanwhile_goes_into_the_next(commits: GroupCommit[int], store: Store) -> None:
    first = commits.commit(batch(1))
    await asyncio.sleep(0)
    others = [commits.commit(batch(number)) for number in (2, 3, 2)]
    store.results.put_nowait(None)
    assert await first == 1
    assert not any(other.done() for other in others)
    store.results.put_nowait(None)
    assert await asyncio.gather(*others) == [2, 2, 2]
    assert store.batches == [["goal-0001"], ["goal-0002", "goal-0003"]]


@pytest.mark.parametrize("error", [OSError("away"), KeyError("a defect")])
async def test_an_error_is_for_those_of_its_transaction(
    commits: GroupCommit[int], store: Store, error: Exception
) -> None:
    first = commits.commit(batch(1))
    await asyncio.sleep(0)
    second = commits.commit(batch(2))
    store.results.put_nowait(error)
    with pytest.raises(type(error)):
        await first
    store.results.put_nowait(None)
    assert await second == 2


async def test_what_is_given_up_is_left_out_unless_it_has_begun(commits: GroupCommit[int], store: Store) -> None:
    begun = commits.commit(batch(1))
    await asyncio.sleep(0)
    waiting = [commits.commit(batch(number)) for number in (2, 3)]
    begun.cancel()
    waiting[0].cancel()
    store.results.put_nowait(None)
    store.results.put_nowait(None)
    assert await waiting[1] == 2
    assert store.batches == [["goal-0001"], ["goal-0003"]]

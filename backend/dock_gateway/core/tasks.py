"""Background tasks that end with their owner."""

import asyncio
import logging
from collections import OrderedDict
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any, Generic, Protocol, TypeVar

from dock_gateway.core.errors import GatewayError

log = logging.getLogger(__name__)

T = TypeVar("T")


async def cancel(*tasks: "asyncio.Task[Any]") -> None:
    """Cancel tasks and wait until they have ended. Their exceptions are ignored."""
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


class Tasks:
    """Background tasks of one owner. Their exceptions are logged.

    Args:
        doing: Their purpose, for the log.
    """

    def __init__(self, doing: str) -> None:
        self._doing = doing
        self._running: set[asyncio.Task[Any]] = set()

    def __len__(self) -> int:
        return len(self._running)

    def spawn(self, work: Coroutine[Any, Any, T]) -> asyncio.Task[T]:
        """Run a coroutine in a background task."""
        task = asyncio.create_task(work)
        self._running.add(task)
        task.add_done_callback(self._ended)
        return task

    def repeat(self, work: Callable[[], Awaitable[object]], interval: float, doing: str) -> None:
        """Do something again and again in a background task. What it raises is logged, and ends nothing.

        Args:
            work: What to do.
            interval: Seconds between the end of one time and the next.
            doing: Its purpose, for the log.
        """
        self.spawn(_repeat(work, interval, doing))

    def _ended(self, task: "asyncio.Task[Any]") -> None:
        self._running.discard(task)
        if task.cancelled() or (error := task.exception()) is None:
            return
        if isinstance(error, GatewayError):
            log.info("while %s: %s", self._doing, error.detail)
        else:
            log.error("while %s", self._doing, exc_info=error)

    async def drain(self, timeout: float = 1.0) -> None:
        """Wait until all tasks have ended, at most `timeout` seconds."""
        if self._running:
            await asyncio.wait(self._running, timeout=timeout)

    async def close(self) -> None:
        """Cancel all tasks and wait for them."""
        await cancel(*self._running)


async def _repeat(work: Callable[[], Awaitable[object]], interval: float, doing: str) -> None:
    while True:
        try:
            await work()
        except Exception:
            log.exception("while %s", doing)
        await asyncio.sleep(interval)


class PendingFacts(Generic[T]):
    """A fact about each goal, such as why it was rejected, that may arrive a little later than it is needed.

    Args:
        wait: Seconds to wait for a fact.
        limit: Maximum number of facts kept.
    """

    def __init__(self, wait: float, limit: int = 2000) -> None:
        self._wait = wait
        self._limit = limit
        self._facts: OrderedDict[str, T] = OrderedDict()
        self._waiting: dict[str, asyncio.Event] = {}

    def __len__(self) -> int:
        return len(self._facts)

    def __contains__(self, goal_id: str) -> bool:
        return goal_id in self._facts

    def put(self, goal_id: str, fact: T) -> None:
        """Store a fact; it replaces an older one."""
        self._facts[goal_id] = fact
        if len(self._facts) > self._limit:
            self._facts.popitem(last=False)
        if event := self._waiting.get(goal_id):
            event.set()

    async def wait_for(self, goal_id: str) -> T | None:
        """Return the fact, waiting for it at most `wait` seconds, or None."""
        if goal_id not in self._facts:
            event = self._waiting.setdefault(goal_id, asyncio.Event())
            try:
                async with asyncio.timeout(self._wait):
                    await event.wait()
            except TimeoutError:
                return None
            finally:
                self._waiting.pop(goal_id, None)
        return self._facts.get(goal_id)


class _Closable(Protocol):
    async def close(self) -> None: ...


ClosableT = TypeVar("ClosableT", bound=_Closable)


def closed_by(stack: AsyncExitStack, part: ClosableT) -> ClosableT:
    """Return a part, which is closed when the stack is."""
    stack.push_async_callback(part.close)
    return part


@asynccontextmanager
async def closing(part: ClosableT) -> AsyncIterator[ClosableT]:
    """Close a part when the block ends."""
    try:
        yield part
    finally:
        await part.close()

"""Virtual time: an event loop that never waits. When nothing is left to do now, its clock jumps to the next timer."""

import asyncio
import selectors
import time
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar
from unittest.mock import patch

P = ParamSpec("P")
T = TypeVar("T")

START_NS = 1_700_000_000_000_000_000  # when the simulated time begins: the past for all that reads the real clock


class _Selector(selectors.DefaultSelector):  # type: ignore[valid-type,misc] - the class depends on the platform
    """Moves the clock on instead of waiting."""

    now = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """Return at once what is ready; `timeout` seconds have passed then."""
        if timeout is None:
            raise RuntimeError("the simulation waits for something that never comes")
        self.now += max(0.0, timeout)
        return []


class VirtualLoop(asyncio.SelectorEventLoop):
    """An event loop whose time is virtual, in seconds from 0."""

    def __init__(self) -> None:
        self._virtual = _Selector()
        super().__init__(self._virtual)

    def time(self) -> float:
        """Return the virtual time."""
        return self._virtual.now

    def stall(self, seconds: float) -> None:
        """Let time pass in which nothing has a turn."""
        self._virtual.now += seconds

    def run_in_executor(  # type: ignore[override] - the result is there at once
        self, executor: Executor | None, func: Callable[..., T], *args: Any
    ) -> asyncio.Future[T]:
        """Do at once what a thread would do, which takes no virtual time."""
        done: asyncio.Future[T] = self.create_future()
        try:
            done.set_result(func(*args))
        except Exception as error:  # noqa: BLE001 - whatever it is, the caller gets it
            done.set_exception(error)
        return done

    def time_ns(self) -> int:
        """Return the virtual time, in nanoseconds since 1970."""
        return START_NS + round(self._virtual.now * 1e9)


@contextmanager
def _clocks_of(loop: VirtualLoop) -> Iterator[None]:
    with (
        patch.object(time, "time_ns", loop.time_ns),
        patch.object(time, "time", lambda: loop.time_ns() / 1e9),
        patch.object(time, "monotonic", loop.time),
    ):
        yield


def run(work: Coroutine[Any, Any, T]) -> T:
    """Run a coroutine in virtual time."""
    loop = VirtualLoop()
    with _clocks_of(loop):
        try:
            return loop.run_until_complete(work)
        finally:
            left = asyncio.all_tasks(loop)
            for task in left:
                task.cancel()
            if left:
                loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
            loop.close()


def in_virtual_time(test: Callable[P, Coroutine[Any, Any, None]]) -> Callable[P, None]:
    """Let time pass in a test as fast as it can: no machine is too busy for it. Its fixtures are made outside."""

    @wraps(test)
    def tested(*args: P.args, **kwargs: P.kwargs) -> None:
        run(test(*args, **kwargs))

    return tested

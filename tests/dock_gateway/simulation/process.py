"""A process of the simulation: its tasks end with it, at any moment."""

import asyncio
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager
from contextvars import ContextVar, Token
from typing import Any

from dock_gateway.core.fanout import Fanout
from dock_gateway.http.parts import Parts
from tests.dock_gateway.simulation.chance import Chance

# The process that the running code belongs to.
_running: ContextVar["Process"] = ContextVar("_running")


class Process:
    """A process, from its start until it is killed.

    Attributes:
        fanout, parts: What its readers read from; they are there once it is `ready`.
    """

    fanout: Fanout
    parts: Parts

    def __init__(self, chance: Chance, name: str) -> None:
        self.chance = chance
        self.name = name
        self.dead = False
        self.ready = False
        self._tasks: dict[asyncio.Task[Any], None] = {}  # a set would have another order in each run

    @contextmanager
    def running(self) -> Iterator[None]:
        """Let all tasks that are begun here be of this process."""
        token: Token[Process] = _running.set(self)
        try:
            yield
        finally:
            _running.reset(token)

    def spawn(self, work: Coroutine[Any, Any, Any]) -> "asyncio.Task[Any]":
        """Run something in this process."""
        with self.running():
            return self.chance.loop.create_task(work)

    def kill(self) -> None:
        """End this process at once, whatever it is doing."""
        self.dead = True
        self.chance.say(self.name, "killed")
        for task in list(self._tasks):
            task.cancel()

    def note(self, task: "asyncio.Task[Any]") -> None:
        """Remember a task of this process, which ends with it."""
        self._tasks[task] = None
        task.add_done_callback(self._tasks.pop)


def noted(loop: asyncio.AbstractEventLoop, work: Any, **more: Any) -> "asyncio.Task[Any]":
    """Make a task of the process that is running: a task factory."""
    task = asyncio.Task(work, loop=loop, **more)
    if (process := _running.get(None)) is not None:
        process.note(task)
    return task

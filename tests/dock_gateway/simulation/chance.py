"""What happens by chance in a run: delays and faults, all decided by one seed, and a record of it."""

import asyncio
import random
import uuid
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from contextvars import Context
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

from tests.support.virtual import START_NS, VirtualLoop

TICK = 1e-6  # seconds between messages that keep their order


@dataclass(frozen=True)
class Faults:
    """What goes wrong in a run. Times are in seconds.

    Attributes:
        gateways: How many there are. They share the database; a single one has it for itself.
        goals: How many are sent.
        kills: How many times a gateway is killed.
        moves: How many times the reader moves without need.
        latency: Of each message, at most.
        lag: By how much the messages to one gateway are late now and then, at most.
        discovery: How long a gateway that has just started does not hear an action server, at most.
        database: How long a transaction takes, at most.
        stall: How long one takes now and then.
        loss, repeat, reorder: How likely it is that a message of the broker is lost, comes twice, or is overtaken.
        cuts: How many times the broker is away.
    """

    gateways: int = 2
    goals: int = 8
    kills: int = 2
    moves: int = 2
    latency: float = 0.004
    lag: float = 0.8
    discovery: float = 1.0
    database: float = 0.006
    stall: float = 0.4
    loss: float = 0.003
    repeat: float = 0.01
    reorder: float = 0.003
    cuts: int = 2


class Chance:
    """The network, the clock and the dice of one run.

    Args:
        seed: Decides everything.
        faults: What goes wrong.
    """

    def __init__(self, seed: int, faults: Faults) -> None:
        self.random = random.Random(seed)
        self._ids = random.Random(seed)
        self.faults = faults
        loop = asyncio.get_running_loop()
        assert isinstance(loop, VirtualLoop)
        self.loop = loop
        self.said: list[tuple[float, str, str]] = []
        self.tasks: set[asyncio.Task[Any]] = set()
        self._lags: dict[str, float] = {}

    @contextmanager
    def deciding_ids(self) -> Iterator[None]:
        """Let the seed decide the ids of goals, too, by which the database sorts."""

        def make() -> uuid.UUID:
            return uuid.UUID(int=self._ids.getrandbits(128), version=4)

        with patch.object(uuid, "uuid4", make):
            yield

    def say(self, who: str, what: str) -> None:
        """Note what happens."""
        self.said.append((self.loop.time(), who, what))

    def latency(self) -> float:
        """Return the time that a message takes."""
        return self.random.uniform(0.0002, self.faults.latency)

    def lag(self, name: str) -> None:
        """Let a gateway be behind, as on a busy machine."""
        lag = self.random.uniform(0, self.faults.lag)
        self._lags[name] = self.loop.time() + lag
        self.say(name, f"lags by {lag:.3f} s")

    def lag_of(self, name: str) -> float:
        """Return how far a gateway is behind now."""
        return max(0.0, self._lags.get(name, 0.0) - self.loop.time())

    def database_delay(self) -> float:
        """Return the time that a request to the database, or its answer, takes."""
        delay = self.random.uniform(0.0005, self.faults.database / 2)
        return self.random.uniform(0, self.faults.stall) if self.random.random() < 0.02 else delay

    def later(self, delay: float, do: Callable[[], object]) -> None:
        """Do something later that is of no gateway, and does not end with one."""
        self.loop.call_later(delay, do, context=Context())

    def spawn(self, work: Coroutine[Any, Any, None]) -> None:
        """Run something that is of no gateway."""
        task = self.loop.create_task(work, context=Context())
        self.tasks.add(task)
        task.add_done_callback(self.tasks.discard)


def short(identity: str) -> str:
    """Return an id as milliseconds since the start, kind and subject."""
    return f"{(int(identity[:20]) - START_NS) / 1e6:.6f}{identity[20:]}" if identity else "nothing"

"""The file in which latched stops survive a restart, and its writer, which does not delay a stop."""

import asyncio
import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import orjson

from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import encode
from dock_gateway.core.namespace import ALL_ROBOTS
from dock_gateway.core.tasks import cancel
from dock_gateway.latch.latches import Latch

log = logging.getLogger(__name__)

# Seconds before a failed write is retried.
RETRY_AFTER = 1.0
# Maximum seconds to wait for the last write when the gateway closes.
CLOSE_WITHIN = 0.5

NOT_YET = "it is not on the disk yet"


class LatchFile:
    """Stores latched stops so that they survive a crash or a power cut."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self) -> dict[str, Latch]:
        """Return the stored latches. If part of the file is unreadable, all robots are held: no stop is lost."""
        problem: Exception | None = None
        stops: dict[str, Any] = {}
        try:
            stops = _read_object(self.path.read_bytes())
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, TypeError) as error:
            problem = error
        held: dict[str, Latch] = {}
        for name, stop in stops.items():
            namespace = f"/{name.strip('/')}"
            try:
                held[namespace] = _read_latch(stop)
            except (ValueError, TypeError, KeyError) as error:
                problem, held[namespace] = error, Latch(utc_now())
        if problem is not None:
            log.error("%s cannot be read, so all robots count as stopped: %r", self.path, problem)
            held.setdefault(ALL_ROBOTS, Latch(utc_now()))
        return held

    def write(self, held: dict[str, Latch]) -> None:
        """Store the latches. They are on disk once this returns; until then the old content is.

        Raises:
            OSError: The write failed.
        """
        self.path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        temporary = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            with temporary.open("wb") as file:
                file.write(encode(held))
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(self.path)
        except OSError:
            with suppress(OSError):
                temporary.unlink()
            raise
        folder = os.open(self.path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def _read_object(text: bytes) -> dict[str, Any]:
    value = orjson.loads(text)
    if not isinstance(value, dict):
        raise TypeError(f"no object: {value!r:.100}")
    return value


def _read_latch(stop: dict[str, Any]) -> Latch:
    stopped_at, by = datetime.fromisoformat(stop["stopped_at"]), stop["by"]
    released = tuple(stop.get("released", ()))
    if (
        stopped_at.tzinfo is None
        or not (by is None or isinstance(by, str))
        or not all(isinstance(x, str) for x in released)
    ):
        raise ValueError(f"no stop: {stop!r:.100}")
    return Latch(stopped_at, by, released)


class LatchWriter:
    """Stores the newest state in a thread, retrying until it is on disk.

    Args:
        file: The file.
        on_change: Called when `problem` has changed.
        retry_after: See `RETRY_AFTER`.
        close_within: See `CLOSE_WITHIN`.

    Attributes:
        problem: Why the newest state is not on disk, once that is known; otherwise None.
    """

    def __init__(
        self,
        file: LatchFile,
        on_change: Callable[[], None],
        *,
        retry_after: float = RETRY_AFTER,
        close_within: float = CLOSE_WITHIN,
    ) -> None:
        self.problem: str | None = None
        self._file = file
        self._on_change = on_change
        self._retry_after = retry_after
        self._close_within = close_within
        self._newest: dict[str, Latch] = {}
        self._stored = asyncio.Event()
        self._stored.set()
        self._writing: asyncio.Task[None] | None = None
        self._disk = ThreadPoolExecutor(1, thread_name_prefix="latch")

    def put(self, held: dict[str, Latch]) -> None:
        """Set the newest state and start to store it."""
        self._newest = dict(held)
        self._stored.clear()
        if self._writing is None or self._writing.done():
            self._writing = asyncio.create_task(self._write())

    async def wait(self, timeout: float) -> bool:
        """Wait until the newest state is on disk; after `timeout` seconds, set `problem` and return False."""
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                await self._stored.wait()
        if not self._stored.is_set() and self.problem is None:
            self._report(NOT_YET)
        return self._stored.is_set()

    async def _write(self) -> None:
        loop = asyncio.get_running_loop()
        written = None
        while written is not self._newest:
            written = self._newest
            try:
                await loop.run_in_executor(self._disk, self._file.write, written)
            except Exception as error:  # noqa: BLE001 - whatever it is, a restart would read something else
                self._report(f"{self._file.path} cannot be written: {error}")
                written = None
                await asyncio.sleep(self._retry_after)
        self._stored.set()
        self._report(None)

    def _report(self, problem: str | None) -> None:
        if problem == self.problem:
            return
        if problem is None:
            log.warning("the stops are on the disk again")
        else:
            level = logging.WARNING if problem is NOT_YET else logging.ERROR
            log.log(level, "a restart of the gateway would lose the latest stop or release: %s", problem)
        self.problem = problem
        self._on_change()

    async def close(self) -> None:
        """Wait for the pending write, but not long."""
        await self.wait(self._close_within)
        if self._writing is not None:
            await cancel(self._writing)
        self._disk.shutdown(wait=False)

"""Files on this machine that keep what the database does not take, until it does; across restarts too.

Each process appends to a file of its own, which it holds a lock on. A file without a holder is that of a process that
died, and the next one to start takes it over. A line has a checksum, so that one that was cut off does no harm.
"""

import asyncio
import fcntl
import logging
import os
import time
import uuid
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import TypeVar

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal
from dock_gateway.history.files import identity
from dock_gateway.history.rows import Key, entry_of, line_of

log = logging.getLogger(__name__)

APPEND_TIMEOUT = 5.0

Entry = Goal | Event | Key
Result = TypeVar("Result")


class Spool:
    """The spool in a folder. Its file work is done in order, on a thread of its own.

    Attributes:
        lost: A file was deleted while it was written to: whoever has in memory what was in it writes it again, and sets
            this to False.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="spool")
        self._files: dict[Path, int] = {}  # ours and those taken over, with the descriptor that holds the lock
        self._current: tuple[Path, int] | None = None
        self._counts: dict[Path, int] = {}
        self.lost = False

    @property
    def count(self) -> int:
        """How many entries there are."""
        return sum(self._counts.values())

    async def _run(self, work: Callable[[], Result]) -> Result:
        return await asyncio.get_running_loop().run_in_executor(self._executor, work)

    # ------------------------------------------------------------------ write

    async def append(self, entries: list[Entry]) -> None:
        """Keep entries; they are on the disk once this returns.

        Raises:
            OSError: The disk does not take them; TimeoutError, which is one, where it takes too long.
        """
        if not entries:
            return
        data = b"".join(map(line_of, entries))
        async with asyncio.timeout(APPEND_TIMEOUT):
            path = await self._run(lambda: self._append(data))
        self._counts[path] = self._counts.get(path, 0) + len(entries)

    def _append(self, data: bytes) -> Path:
        if self._current is not None and not _is_at(*self._current):
            log.error("%s was deleted; what is known of it is written again", self._current[0])
            self._remove([self._current[0]])
            self._current, self.lost = None, True
        if self._current is None:
            self._current = self._create()
        path, descriptor = self._current
        size = os.fstat(descriptor).st_size
        try:
            view = memoryview(data)
            while view:
                view = view[os.write(descriptor, view) :]
            os.fdatasync(descriptor)
        except OSError:
            with suppress(OSError):
                os.ftruncate(descriptor, size)
            raise
        return path

    def _create(self) -> tuple[Path, int]:
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        while True:
            path = self._folder / f"{time.time_ns()}-{uuid.uuid4().hex[:8]}.jsonl"
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC, 0o600)
            if self._hold(path, descriptor):
                break
        folder = os.open(self._folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
        return path, descriptor

    def _hold(self, path: Path, descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.fstat(descriptor).st_nlink:  # 0: its holder was done with it a moment ago
                self._files[path] = descriptor
                return True
        except BlockingIOError:
            pass
        os.close(descriptor)
        return False

    # ------------------------------------------------------------------ read, and be done with

    async def take_over(self) -> list[Path]:
        """The files that processes before this one have left."""
        return await self._run(self._adopt)

    def _adopt(self) -> list[Path]:
        adopted = []
        for path in sorted(self._folder.glob("*.jsonl")):
            with suppress(OSError):
                if path not in self._files and self._hold(path, os.open(path, os.O_RDWR | os.O_APPEND | os.O_CLOEXEC)):
                    with path.open("rb") as file:
                        self._counts[path] = sum(1 for _ in file)
                    adopted.append(path)
        return adopted

    def _read(self, paths: list[Path]) -> Iterator[Entry]:
        for path in paths:
            try:
                with path.open("rb") as file:
                    for number, line in enumerate(file, 1):
                        try:
                            entry = entry_of(line)
                        except ValueError as error:
                            log.error("%s, line %d is damaged and left out: %s", path, number, error)
                        else:
                            yield entry
            except OSError as error:
                log.error("%s cannot be read: %s", path, error)

    async def rotate(self) -> list[Path]:
        """Begin a new file with the next entry; returns the files up to now."""

        def rotate() -> list[Path]:
            self._current = None
            return list(self._files)

        return await self._run(rotate)

    async def read(self, paths: list[Path], size: int = 200) -> AsyncIterator[list[Entry]]:
        """The entries of these files, so many at a time."""
        entries = self._read(paths)
        while chunk := await self._run(lambda: list(islice(entries, size))):
            yield chunk

    async def remove(self, paths: list[Path]) -> None:
        """Every entry of these files is in the database."""
        await self._run(lambda: self._remove(paths))

    def _remove(self, paths: list[Path]) -> None:
        for path in paths:
            self._counts.pop(path, None)
            with suppress(OSError):
                path.unlink()
            descriptor = self._files.pop(path, None)
            if descriptor is not None:
                os.close(descriptor)

    async def close(self) -> None:
        """Let go of the files; they stay."""

        def close() -> None:
            for descriptor in self._files.values():
                os.close(descriptor)
            self._files.clear()
            self._current = None

        await self._run(close)
        self._executor.shutdown(wait=False)


def _is_at(path: Path, descriptor: int) -> bool:
    """Whether a file that is open is still the one at its path."""
    opened = os.fstat(descriptor)
    return identity(path) == (opened.st_dev, opened.st_ino)

"""Files on this machine that hold entries until the database takes them, across restarts.

Each process appends to a file of its own and keeps it locked. An unlocked file belongs to a process that died; the next
process to start takes it over. Each line has a checksum, so that a truncated line is detected.
"""

import asyncio
import fcntl
import logging
import os
import time
import uuid
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Generic, TypeVar

from dock_gateway.core.audit import AuditEntry
from dock_gateway.storage.files import identity
from dock_gateway.storage.rows import Entry, audit_entry_of, audit_line_of, entry_of, line_of

log = logging.getLogger(__name__)

APPEND_TIMEOUT = 5.0  # seconds

Result = TypeVar("Result")
SpooledT = TypeVar("SpooledT")


class Files(ABC, Generic[SpooledT]):
    """The spool in a folder. All file operations run in order on one thread.

    Args:
        folder: The folder. None: nothing can be spooled, as nothing shall outlive the process.

    Attributes:
        lost: Whether the current file was deleted. The caller writes what it has in memory again, and resets this.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="spool")
        self._files: dict[Path, int] = {}  # own and adopted files → the descriptor that holds the lock
        self._current: tuple[Path, int] | None = None
        self._counts: dict[Path, int] = {}
        self.lost = False

    @property
    def count(self) -> int:
        """The number of entries."""
        return sum(self._counts.values())

    @staticmethod
    @abstractmethod
    def line_of(entry: SpooledT) -> bytes:
        """Convert an entry to a line."""

    @staticmethod
    @abstractmethod
    def entry_of(line: bytes) -> SpooledT:
        """Convert a line to its entry.

        Raises:
            ValueError: The line is damaged.
        """

    async def _run(self, work: Callable[[], Result]) -> Result:
        return await asyncio.get_running_loop().run_in_executor(self._executor, work)

    # ------------------------------------------------------------------ write

    async def append(self, entries: list[SpooledT]) -> None:
        """Append entries; on return they are on the disk.

        Raises:
            OSError: They cannot be written; its subclass TimeoutError if that takes too long.
        """
        if not entries:
            return
        data = b"".join(map(self.line_of, entries))
        async with asyncio.timeout(APPEND_TIMEOUT):
            path = await self._run(lambda: self._append(data))
        self._counts[path] = self._counts.get(path, 0) + len(entries)

    def _append(self, data: bytes) -> Path:
        if self._current is not None and not _is_at(*self._current):
            log.error("%s was deleted; the entries still in memory are written again", self._current[0])
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
        if self._folder is None:
            raise OSError("a history in memory has no spool")
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
            if os.fstat(descriptor).st_nlink:  # 0: its holder has just removed it
                self._files[path] = descriptor
                return True
        except BlockingIOError:
            pass
        os.close(descriptor)
        return False

    # ------------------------------------------------------------------ read and remove

    async def take_over(self) -> list[Path]:
        """Lock the files that earlier processes left, and return their paths."""
        return await self._run(self._adopt)

    def _adopt(self) -> list[Path]:
        adopted = []
        for path in [] if self._folder is None else sorted(self._folder.glob("*.jsonl")):
            with suppress(OSError):
                if path not in self._files and self._hold(path, os.open(path, os.O_RDWR | os.O_APPEND | os.O_CLOEXEC)):
                    with path.open("rb") as file:
                        self._counts[path] = sum(1 for _ in file)
                    adopted.append(path)
        return adopted

    def _read(self, paths: list[Path]) -> Iterator[SpooledT]:
        for path in paths:
            try:
                with path.open("rb") as file:
                    for number, line in enumerate(file, 1):
                        try:
                            entry = self.entry_of(line)
                        except ValueError as error:
                            log.error("%s, line %d is damaged and skipped: %s", path, number, error)
                        else:
                            yield entry
            except OSError as error:
                log.error("%s cannot be read: %s", path, error)

    async def rotate(self) -> list[Path]:
        """Start a new file with the next entry; return the files so far."""

        def rotate() -> list[Path]:
            self._current = None
            return list(self._files)

        return await self._run(rotate)

    async def read(self, paths: list[Path], size: int = 200) -> AsyncIterator[list[SpooledT]]:
        """Yield the entries of these files, `size` at a time."""
        entries = self._read(paths)
        while chunk := await self._run(lambda: list(islice(entries, size))):
            yield chunk

    async def remove(self, paths: list[Path]) -> None:
        """Delete files whose entries are all in the database."""
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
        """Close and unlock the files without deleting them."""

        def close() -> None:
            for descriptor in self._files.values():
                os.close(descriptor)
            self._files.clear()
            self._current = None

        await self._run(close)
        self._executor.shutdown(wait=False)


class Spool(Files[Entry]):
    """The spool of goals, events and keys."""

    line_of = staticmethod(line_of)
    entry_of = staticmethod(entry_of)


class AuditSpool(Files[AuditEntry]):
    """The spool of entries of the audit log."""

    line_of = staticmethod(audit_line_of)
    entry_of = staticmethod(audit_entry_of)


def _is_at(path: Path, descriptor: int) -> bool:
    """Return whether an open file is still the one at its path."""
    opened = os.fstat(descriptor)
    return identity(path) == (opened.st_dev, opened.st_ino)

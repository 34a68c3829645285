"""File operations on SQLite databases. A damaged file is renamed, not deleted, so that it can be repaired."""

import fcntl
import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

LOCK_TIMEOUT = 2.0  # seconds


def identity(path: Path) -> tuple[int, int] | None:
    """Return device and inode of the file at a path, None if there is none."""
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None
    return found.st_dev, found.st_ino


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder while its files, which other gateways use too, are renamed, removed or opened; blocks.

    Raises:
        OSError: There is no such folder; its subclass TimeoutError if another gateway holds the lock too long.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        deadline = time.monotonic() + LOCK_TIMEOUT
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > deadline:
                    raise TimeoutError(f"another gateway keeps {folder} locked") from None
                time.sleep(0.01)
        yield
    finally:
        os.close(descriptor)


MARK = ".corrupt-"
STAMP = "%Y%m%dT%H%M%S.%fZ"
# Keeps a bad disk from filling up with damaged files.
MAX_ASIDE = 20
# Suffixes of the other files of a database: its log and its shared memory.
LOG_FILES = ("-wal", "-shm")


def is_damage(error: BaseException | None) -> bool:
    """Return whether SQLite reports a damaged file or no database; not a locked, full or inaccessible one."""
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    return code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def beside(path: Path, suffix: str) -> Path:
    """Return the path of a file that belongs to a database."""
    return path.with_name(path.name + suffix)


def set_aside(path: Path) -> Path:
    """Rename a damaged database and its other files; return its new path. It must not be opened meanwhile.

    Raises:
        OSError: It cannot be renamed, or too many damaged files are there already.
    """
    if len(found := aside(path)) >= MAX_ASIDE:
        raise OSError(f"{len(found)} damaged files are already kept in {path.parent}; check the disk")
    new = beside(path, MARK + datetime.now(UTC).strftime(STAMP))
    rename(path, new)
    return new


def aside(path: Path) -> dict[datetime, Path]:
    """Return the damaged files, by the time at which they were renamed."""
    found = {}
    for each in path.parent.iterdir():
        name, _, stamp = each.name.rpartition(MARK)
        if name == path.name:
            with suppress(ValueError):
                found[datetime.strptime(stamp, STAMP).replace(tzinfo=UTC)] = each
    return found


def rename(path: Path, new: Path) -> None:
    """Rename a database and its other files."""
    path.rename(new)
    for suffix in LOG_FILES:
        with suppress(FileNotFoundError):
            beside(path, suffix).rename(beside(new, suffix))

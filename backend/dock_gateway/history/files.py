"""A damaged SQLite file is of use to whoever mends it: it is set aside, under a name that says so."""

import fcntl
import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

LOCK_TIMEOUT = 2.0


def identity(path: Path) -> tuple[int, int] | None:
    """Which file is at a path, whatever it is called; None where there is none."""
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None
    return found.st_dev, found.st_ino


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Rename, remove and open files that other gateways use, too; blocks until they have done so.

    Raises:
        OSError: There is no such folder; TimeoutError, which is one, where another gateway takes too long.
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
                    raise TimeoutError(f"another gateway does not let go of {folder}") from None
                time.sleep(0.01)
        yield
    finally:
        os.close(descriptor)


MARK = ".corrupt-"
STAMP = "%Y%m%dT%H%M%S.%fZ"
# A disk that damages each new file must not be filled with them.
MAX_ASIDE = 20
# What belongs to a database besides its file: what is not in that yet, and who uses it.
LOG_FILES = ("-wal", "-shm")


def is_damage(error: BaseException | None) -> bool:
    """Whether SQLite says that a file is damaged, or no database at all; not that it is locked, full or barred."""
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    return code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def beside(path: Path, suffix: str) -> Path:
    """A file that belongs to a database."""
    return path.with_name(path.name + suffix)


def set_aside(path: Path) -> Path:
    """Rename a damaged database with all that belongs to it; returns its new path. Nobody may open it meanwhile.

    Raises:
        OSError: It cannot be renamed, or too many have been set aside already.
    """
    if len(found := aside(path)) >= MAX_ASIDE:
        raise OSError(f"{len(found)} damaged files are kept in {path.parent} already; look at the disk")
    new = beside(path, MARK + datetime.now(UTC).strftime(STAMP))
    rename(path, new)
    return new


def aside(path: Path) -> dict[datetime, Path]:
    """The damaged files that were set aside, by when that was."""
    found = {}
    for each in path.parent.iterdir():
        name, _, stamp = each.name.rpartition(MARK)
        if name == path.name:
            with suppress(ValueError):
                found[datetime.strptime(stamp, STAMP).replace(tzinfo=UTC)] = each
    return found


def rename(path: Path, new: Path) -> None:
    """Rename a database with all that belongs to it."""
    path.rename(new)
    for suffix in LOG_FILES:
        with suppress(FileNotFoundError):
            beside(path, suffix).rename(beside(new, suffix))

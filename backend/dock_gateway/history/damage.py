"""A damaged SQLite file is of use to whoever mends it: it is set aside, under a name that says so."""

import sqlite3
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

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

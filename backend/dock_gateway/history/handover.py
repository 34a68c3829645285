"""The files of earlier versions, which all gateways of a user shared: the first gateway that starts takes them over."""

import fcntl
import logging
import sqlite3
from contextlib import closing, suppress
from pathlib import Path

from dock_gateway.history.files import is_damage, locked, rename

log = logging.getLogger(__name__)


def take_over_database(old: Path, new: Path) -> None:
    """Rename a SQLite database, unless there is a new one already or a gateway of an earlier version uses the old one.

    Args:
        old: Where it was; both are in one folder.
        new: Where it is kept from now on.
    """
    if not old.exists() or new.exists():
        return
    try:
        with locked(old.parent):
            if old.exists() and not new.exists():
                _rename(old, new)
    except (OSError, sqlite3.Error) as error:
        log.warning("%s is left alone, and a new history is begun in %s: %s", old, new, error)


def _rename(old: Path, new: Path) -> None:
    try:
        with closing(sqlite3.connect(old, timeout=0.5, isolation_level=None)) as connection:
            # Brings what is in the log into the file, and fails where another process has the file open.
            connection.execute("PRAGMA journal_mode=DELETE")
    except sqlite3.DatabaseError as error:
        if not is_damage(error):
            raise
    rename(old, new)
    log.info("%s is now %s", old, new)


def take_over_spool(old: Path, new: Path) -> None:
    """Move the spool's files that no living process holds.

    Args:
        old: The folder where they were.
        new: The folder where they are kept from now on.
    """
    try:
        for path in sorted(old.glob("*.jsonl")):
            with path.open("rb") as file, suppress(BlockingIOError):
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                new.mkdir(mode=0o700, parents=True, exist_ok=True)
                path.rename(new / path.name)
        with suppress(OSError):
            old.rmdir()
    except OSError as error:
        log.warning("the spool in %s is left alone: %s", old, error)

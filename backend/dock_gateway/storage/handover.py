"""Takes over the files of earlier versions, which all gateways of a user shared. The first gateway to start wins."""

import fcntl
import logging
import sqlite3
from contextlib import closing, suppress
from pathlib import Path

from dock_gateway.storage.files import is_damage, locked, rename

log = logging.getLogger(__name__)


def take_over_database(old: Path, new: Path) -> None:
    """Rename a SQLite database, unless the new one exists or an earlier version's gateway uses the old one.

    Args:
        old: Its old path.
        new: Its new path, in the same folder.
    """
    if not old.exists() or new.exists():
        return
    try:
        with locked(old.parent):
            if old.exists() and not new.exists():
                _rename(old, new)
    except (OSError, sqlite3.Error) as error:
        log.warning("%s is not changed, and a new history is started in %s: %s", old, new, error)


def _rename(old: Path, new: Path) -> None:
    try:
        with closing(sqlite3.connect(old, timeout=0.5, isolation_level=None)) as connection:
            # Merges the log into the file; fails if another process has the file open.
            connection.execute("PRAGMA journal_mode=DELETE")
    except sqlite3.DatabaseError as error:
        if not is_damage(error):
            raise
    rename(old, new)
    log.info("renamed %s to %s", old, new)


def take_over_spool(old: Path, new: Path) -> None:
    """Move the spool files that no running process has locked.

    Args:
        old: Their old folder.
        new: Their new folder.
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
        log.warning("the spool in %s is not changed: %s", old, error)

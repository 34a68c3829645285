"""Finds the database of a command, and others: a gateway with other ROS variables uses another one."""

from pathlib import Path

import click

from dock_gateway.doctor.machine import SQLITE
from dock_gateway.settings import Settings, data_file

# Names of databases in the user's data directory, and the end of the name of SQLite's log while one is open.
DATABASES, OPEN = "history*.db", "-wal"


class Choice:
    """The database that a command has chosen, and the others as they are before it is opened.

    Args:
        settings: The settings of the command.
    """

    def __init__(self, settings: Settings) -> None:
        self._url = settings.database
        self._given = bool(settings.database_url)
        own = Path(self._url.removeprefix(SQLITE)) if self._url.startswith(SQLITE) else None
        self._used = own is not None and is_open(own)
        others = [path for path in sorted(data_file("").glob(DATABASES)) if own is None or not _same(path, own)]
        self._open = [path for path in others if is_open(path)]
        written = 0.0 if own is None else _written_at(own)
        self._newer = [path for path in others if not is_open(path) and _written_at(path) > written]

    def report(self, verb: str) -> None:
        """Say which database it was, and where a gateway may use another one. Goes to the standard error output.

        Args:
            verb: The operation there, such as `stored`.
        """
        from dock_gateway.storage.database import display  # noqa: PLC0415 - takes a second

        click.echo(f"{verb} in {display(self._url)}", err=True)
        if self._used or (self._given and not self._open):
            return
        if self._open:
            why, paths = "a gateway seems to use another database, and knows nothing of this one", self._open
        elif self._newer:
            why, paths = "a gateway with another ROS_DOMAIN_ID or discovery range has used its own since", self._newer
        else:
            return
        options = "".join(f"\n  --database-url {SQLITE}{path}" for path in paths)
        click.secho(f"WARNING: {why}:{options}", fg="yellow", err=True)
        click.echo(
            "If that is the one you mean, run this again with that option, or with the gateway's ROS_DOMAIN_ID and "
            "ROS_AUTOMATIC_DISCOVERY_RANGE.",
            err=True,
        )


def is_open(path: Path) -> bool:
    """Return whether a process has opened a SQLite database, or was killed with it open."""
    return path.with_name(path.name + OPEN).exists()


def _written_at(path: Path) -> float:
    """Return when a file was written, in seconds since 1970; 0 if there is none."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0


def _same(path: Path, other: Path) -> bool:
    return path.resolve() == other.resolve()

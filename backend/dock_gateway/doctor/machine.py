"""Checks the machine: port, clock, disk and database."""

import ctypes
import errno
import os
import shutil
import socket
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from dock_gateway.doctor.check import Check, Level, judge
from dock_gateway.settings import Settings

SQLITE = "sqlite:///"
# What to do about an address that cannot be listened on.
ADVICE = {
    errno.EADDRINUSE: "is a gateway running already? {option} takes another",
    errno.EACCES: "ports below 1024 are for root; {option} takes another",
    errno.EADDRNOTAVAIL: "--host has to be an address of this machine",
}
# Bytes of free space below which the history will soon not fit.
LITTLE = 1_000_000_000
# Bytes of free space below which the history does not fit now.
NONE = 50_000_000
# Seconds for an answer of a gateway, or of a database.
PATIENCE = 3.0
# What adjtimex returns if the clock is not synchronized.
TIME_ERROR = 5


def check_machine(settings: Settings) -> list[Check]:
    """Check the port, the clock, the disk and the database."""
    return [check_port(settings), check_clock(), check_disk(settings), check_database(settings)]


# ---------------------------------------------------------------------- port


def own_url(settings: Settings) -> str:
    """Return the gateway's URL on this machine."""
    host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(settings.host, settings.host)  # noqa: S104 - every address is ours
    scheme = "https" if settings.tls else "http"
    return f"{scheme}://[{host}]:{settings.port}" if ":" in host else f"{scheme}://{host}:{settings.port}"


def find_port_fault(settings: Settings) -> str | None:
    """Return why one of the gateway's ports cannot be listened on, and what to do; None if all can."""
    faults = (_find_port_fault(settings.host, port, name) for name, port in settings.ports.items())
    return next(filter(None, faults), None)


def _find_port_fault(host: str, port: int, name: str) -> str | None:
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        for family, _, _, _, address in dict.fromkeys(addresses):
            socket.create_server(address[:2], family=family).close()
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno in ADVICE else error.strerror or str(error)
        advice = ADVICE.get(error.errno or 0, "--host has to be a name or an address of this machine")
        advice = advice.format(option=f"--{name.replace('_', '-')}")
        return f"cannot listen on {host} port {port}: {reason.lower()}; {advice}"
    return None


def check_port(settings: Settings) -> Check:
    """Check that the port is free, or that a gateway listens there."""
    fault, url = find_port_fault(settings), own_url(settings)
    if fault is not None and _is_gateway(url):
        return Check("port", Level.OK, f"a gateway runs at {url}")
    return judge("port", fault, f"{settings.host} port {settings.port} is free")


def _is_gateway(url: str) -> bool:
    import httpx2  # noqa: PLC0415 - servers that start do not need it

    try:  # its certificate is for another name than that of this machine's loopback interface
        answer = httpx2.get(f"{url}/readyz", timeout=PATIENCE, trust_env=False, verify=False)
        return "ready" in answer.json()
    except (httpx2.HTTPError, httpx2.InvalidURL, ValueError, TypeError):
        return False


# ---------------------------------------------------------------------- clock


def check_clock(now: Callable[[], float] = time.time, *, synchronized: bool | None = None) -> Check:
    """Check that the clock is right, by what this machine knows.

    Args:
        now: The time in seconds since 1970.
        synchronized: Whether the system synchronizes it; None: ask the system.
    """
    set_clock = "run `sudo timedatectl set-ntp true`"
    said = datetime.fromtimestamp(now(), UTC)
    if said.timestamp() < Path(__file__).stat().st_ctime:
        return Check("clock", Level.ERROR, f"it is {said:%Y-%m-%d}, before the installation: {set_clock}")
    if synchronized is None:
        synchronized = ctypes.CDLL(None).adjtimex(ctypes.create_string_buffer(512)) != TIME_ERROR
    drifts = f"it is {said:%Y-%m-%d %H:%M} UTC by a clock that nothing synchronizes: {set_clock}"
    return judge("clock", None if synchronized else drifts, f"it is {said:%Y-%m-%d %H:%M} UTC", Level.WARNING)


# ---------------------------------------------------------------------- disk


def check_disk(settings: Settings) -> Check:
    """Check that there is space for the history: the database, or what waits for it."""
    folder = settings.spool_folder
    if settings.database.startswith(SQLITE):
        folder = Path(settings.database.removeprefix(SQLITE)).parent
    folder = next(each for each in (folder, *folder.absolute().parents) if each.is_dir())
    free = shutil.disk_usage(folder).free
    found = f"{free / 1e9:.1f} GB are free in {folder}"
    if free >= LITTLE:
        return Check("disk", Level.OK, found)
    advice = f"{found}: make space, or name a database on another disk with --database-url"
    return Check("disk", Level.ERROR if free < NONE else Level.WARNING, advice)


# ---------------------------------------------------------------------- database


def find_database_fault(settings: Settings) -> str | None:
    """Return why there cannot be a database where the settings name one, and what to do; None if there can.

    A database that does not answer is no such fault: the gateway starts without it.
    """
    url = settings.database
    if url == "memory:":
        return None
    if not url.startswith(SQLITE):
        from dock_gateway.storage.database import display  # noqa: PLC0415 - takes a second

        try:
            display(url)
        except Exception as error:  # noqa: BLE001 - SQLAlchemy's and Python's
            return f"database_url: it is no postgresql://user@host/name: {error}"
        return None
    path = Path(url.removeprefix(SQLITE))
    advice = f"name another file with --database-url {SQLITE}/path/to/history.db"
    if path.is_dir():
        return f"the database {path} is a folder: {advice}"
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        return f"the folder {path.parent} of the database cannot be made: {(error.strerror or '').lower()}; {advice}"
    return None


def check_database(settings: Settings) -> Check:
    """Check that the database can be used. It is not changed."""
    url = settings.database
    if (fault := find_database_fault(settings)) is not None:
        return Check("database", Level.ERROR, fault)
    if url == "memory:":
        return Check("database", Level.OK, "nothing is stored, as the settings say (memory:)")
    if url.startswith(SQLITE):
        return _check_file(Path(url.removeprefix(SQLITE)))
    return _check_server(url)


def _check_file(path: Path) -> Check:
    there = path.exists()
    if not os.access(path if there else path.parent, os.R_OK | os.W_OK):
        advice = f"make it your own with `sudo chown -R $USER {path.parent}`, or name another one with --database-url"
        return Check("database", Level.ERROR, f"{path} may not be written: {advice}")
    if not there:
        return Check("database", Level.OK, f"{path} is made at the first start")
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=PATIENCE)) as database:
            database.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except sqlite3.Error as error:
        advice = "a gateway that starts renames a damaged file and makes a new one"
        return Check("database", Level.WARNING, f"{path} cannot be read: {error}; {advice}")
    return Check("database", Level.OK, f"{path}, {path.stat().st_size / 1e6:.1f} MB")


def _check_server(url: str) -> Check:
    import asyncio  # noqa: PLC0415 - takes a while, like the others

    import asyncpg  # noqa: PLC0415

    from dock_gateway.storage.database import display  # noqa: PLC0415

    async def ask() -> str:
        connection = await asyncpg.connect(url, timeout=PATIENCE)
        try:
            return str(await connection.fetchval("SHOW server_version"))
        finally:
            await connection.close(timeout=PATIENCE)

    shown = display(url)
    try:
        return Check("database", Level.OK, f"{shown} answers: PostgreSQL {asyncio.run(ask())}")
    except (OSError, TimeoutError, ValueError, asyncpg.PostgresError, asyncpg.InterfaceError) as error:
        why = str(error).partition("\n")[0] or type(error).__name__
        advice = "start it, or name another one with --database-url"
        return Check("database", Level.ERROR, f"{shown} does not answer: {why}; {advice}")

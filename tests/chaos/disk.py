"""A gateway under load, the disk that it stores on, and what may happen to that."""

import errno
import os
import resource
import sqlite3
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import httpx2

from dock_gateway.core.event import stamp_of
from tests.chaos.fleet import Fleet
from tests.chaos.load import Load, ends
from tests.support.gateway import RunningGateway
from tests.support.waiting import wait_until


class Disk:
    """The folder that holds all that a gateway stores, as the gateway (`at`) and as the test (`seen`) name it."""

    def __init__(self, at: Path, seen: Path | None = None) -> None:
        self.at, self.seen = at, seen or at
        self.file = self.seen / "history.db"
        self.settings = {
            "database_url": f"sqlite:///{at}/history.db",
            "spool_path": f"{at}/spool",
            "stop_path": f"{at}/stops.json",
        }

    @property
    def damaged_files(self) -> list[Path]:
        return [path for path in self.seen.glob("history.db.corrupt-*") if path.name.endswith("Z")]


class Trial:
    """A gateway under load, and what is expected of the goals that it accepted."""

    def __init__(self, disk: Disk, fleet: Fleet, load: Load, executed: Path) -> None:
        self.disk, self.fleet, self.load, self.executed = disk, fleet, load, executed
        self.gone: set[str] = set()  # goals that went with the file that held them
        self.unsure: set[int] = set()  # goals that were being sent when nobody was left who knew their key
        self.figures: dict[str, Any] = {}

    @property
    def gateway(self) -> RunningGateway:
        return self.fleet.any()

    @property
    def history(self) -> dict[str, Any]:
        state: dict[str, Any] = self.gateway.http.get("/readyz").json()["history"]
        return state

    def restart(self, meanwhile: Callable[[], None]) -> None:
        self.fleet.kill(0)
        meanwhile()
        self.fleet.start(0)

    def forget_what_ended(self, fault: str) -> None:
        """The file is lost, but not what the gateway knows: goals that had ended when it noticed may be gone."""
        wait_until(lambda: fault in (self.history["last_error"] or ""), f"the gateway notices that its file is {fault}")
        noticed, reader = time.time_ns(), self.load.reader
        wait_until(lambda: stamp_of(reader.events[-1]["id"]) > noticed, "the reader hears of what was before")
        self.gone |= {event["goal_id"] for event in reader.events if ends(event) and stamp_of(event["id"]) <= noticed}

    def forget_everything(self) -> None:
        """The file is lost, and so is what the gateway knew."""
        self.gone |= set(self.load.accepted.values())
        self.unsure |= {sender.number for sender in self.load.senders} - self.load.accepted.keys()

    def missing(self) -> list[str]:
        """Goals that were accepted, and that the gateway does not know as its own."""
        expected = set(self.load.accepted.values()) - self.gone
        return [goal_id for goal_id in sorted(expected) if status(self, goal_id) is None]

    @property
    def began(self) -> Counter[int]:
        """How often the action server executed each goal."""
        return Counter(map(int, self.executed.read_text().split()))

    def answers(self) -> Counter[str]:
        return sum((sender.answers for sender in self.load.senders), Counter[str]())

    def wait_for_new_goals(self) -> None:
        before, answers = len(self.load.accepted), self.answers()
        try:
            wait_until(lambda: len(self.load.accepted) > before + 2 or self.broken(), "new goals")
        except AssertionError:
            raise AssertionError(f"no new goals, but {self.answers() - answers}; {self.history}") from None
        assert not self.broken(), self.broken()

    def broken(self) -> list[Exception]:
        """What ended a sender or the reader."""
        return [worker.error for worker in (*self.load.senders, self.load.reader) if worker.error is not None]


def status(trial: Trial, goal_id: str) -> str | None:
    try:
        goal = trial.gateway.http.get(f"/goals/{goal_id}").json()
    except httpx2.HTTPError:
        return None
    return goal["status"] if goal.get("origin") == "gateway" else None


# ---------------------------------------------------------------------- what happens to the disk


@contextmanager
def full(trial: Trial) -> Iterator[None]:
    """No file may grow or be written: EFBIG for whoever tries, as any user."""
    pid = trial.gateway.process.pid
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        yield
    finally:
        resource.prlimit(pid, resource.RLIMIT_FSIZE, before)


@contextmanager
def really_full(trial: Trial) -> Iterator[None]:
    """No block is left: ENOSPC."""
    wait_until(lambda: log_emptied(trial.disk.file), "the log of the database is empty: its blocks would be used again")
    filler = trial.disk.seen / "filler"
    with filler.open("wb", buffering=0) as file:
        for size in (65_536, 4096, 1):
            try:
                while True:
                    file.write(b"x" * size)
            except OSError as error:
                if error.errno != errno.ENOSPC:
                    raise
    try:
        yield
    finally:
        filler.unlink()


def log_emptied(path: Path) -> bool:
    """Move the database's log into the database and cut it off; return False if somebody reads it."""
    with closing(sqlite3.connect(path, timeout=10)) as connection:
        busy, _, _ = connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
    return not busy


@contextmanager
def read_only(trial: Trial) -> Iterator[None]:
    """The gateway is killed and starts with files and folders that it may not write."""
    folder = trial.disk.seen

    def allow(*, write: bool) -> None:
        for path in (folder, *folder.rglob("*")):
            path.chmod((0o700 if write else 0o500) if path.is_dir() else (0o600 if write else 0o400))

    trial.restart(lambda: allow(write=False))
    try:
        yield
    finally:
        allow(write=True)


@contextmanager
def locked(trial: Trial) -> Iterator[None]:
    """Another process writes and does not come to an end."""
    with closing(sqlite3.connect(trial.disk.file, isolation_level=None, timeout=10)) as connection:
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield
        finally:
            connection.execute("ROLLBACK")


@contextmanager
def deleted(trial: Trial) -> Iterator[None]:
    for path in trial.disk.seen.glob("history.db*"):
        if ".corrupt-" not in path.name:
            path.unlink()
    trial.forget_what_ended("deleted")
    yield


@contextmanager
def damaged(trial: Trial) -> Iterator[None]:
    overwrite(trial.disk.file)
    trial.forget_what_ended("damaged")
    yield


@contextmanager
def damaged_at_the_start(trial: Trial) -> Iterator[None]:
    def lose() -> None:
        overwrite(trial.disk.file)
        time.sleep(0.5)  # the senders hear the last answers
        trial.forget_everything()

    trial.restart(lose)
    yield


def overwrite(path: Path) -> None:
    with closing(sqlite3.connect(path, timeout=10)) as connection:  # what is in the log would mend the file
        connection.execute("PRAGMA wal_checkpoint(PASSIVE)")
    with path.open("r+b") as file:
        file.write(os.urandom(path.stat().st_size))


FAULTS: dict[str, Callable[[Trial], Any]] = {
    "locked": locked,
    "full": full,
    "read-only": read_only,
    "deleted": deleted,
    "damaged": damaged,
    "damaged at the start": damaged_at_the_start,
}

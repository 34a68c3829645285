"""Keeps the file of docks: writes the shared docks into it, and has docking servers read it again."""

import asyncio
import logging
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.chargers.dock import DockEntry
from dock_gateway.extensions.chargers.dock_database import render, write
from dock_gateway.extensions.chargers.reload_port import ReloadPort
from dock_gateway.extensions.chargers.shared_docks import SharedDocks
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.goals.action import Action
from dock_gateway.goals.docks import Docks

log = logging.getLogger(__name__)

UNREAD = AlertKind("dock_file_unread")
# Seconds between two looks at the docks, and at the servers that have not read them.
INTERVAL = 5.0
# Docking servers that are asked at the same time.
AT_ONCE = 10


class Fault(NamedTuple):
    """What is wrong: with a robot's docking server or, without a robot, with the file."""

    robot: str | None
    since: datetime
    why: str


class DockFile:
    """Keeps the file, and has the docking servers whose `dock_database` it is read it again.

    A server that is away is told when it is back. One that reads another file, or none, is left alone.

    Args:
        path: The file.
        docks: The shared docks.
        known: Says which file a docking server reads.
        servers: Has docking servers read it again.
    """

    def __init__(self, path: Path, docks: SharedDocks, known: Docks, servers: ReloadPort) -> None:
        self._path = _full(path)
        self._docks = docks
        self._known = known
        self._servers = servers
        self._seen: dict[str, DockEntry] = {}
        self._text = self._written = ""
        self._told: dict[str, str] = {}  # what is new to an action's server no more
        self._faults: dict[str, Fault] = {}  # by action; that of the file is without one
        self._tasks = Tasks("keeping the file of docks")

    def start(self) -> None:
        """Keep it from now on."""
        self._tasks.repeat(self.keep, INTERVAL, "keeping the file of docks")

    async def close(self) -> None:
        """Keep it no more; it stays as it is."""
        await self._tasks.close()

    async def keep(self) -> None:
        """Write the file if a dock has changed, and tell each server that has not read it yet."""
        if (docks := dict(self._docks.book.all())) != self._seen:
            self._text = render({name: dock.model_dump() for name, dock in docks.items()})
            self._seen = docks
        if not (text := self._text):
            return  # servers refuse an empty one
        if text != self._written:
            try:
                await asyncio.to_thread(write, self._path, text)
            except OSError as error:
                self._note("", None, f"{self._path} cannot be written: {error.strerror}")
                return
            self._faults.pop("", None)
            self._written = text
            log.info("%s has the shared docks", self._path)
        actions = {action.name: action for action in self._docks.actions.all() if action.verb == "dock"}
        self._told = {name: told for name, told in self._told.items() if name in actions}
        self._faults = {name: fault for name, fault in self._faults.items() if not name or name in actions}
        limit = asyncio.Semaphore(AT_ONCE)

        async def tell(action: Action) -> None:
            async with limit:
                await self._tell(action, text)

        await asyncio.gather(*(tell(each) for name, each in actions.items() if self._told.get(name) != text))

    async def _tell(self, action: Action, text: str) -> None:
        robot = self._docks.robots.owner(action.name)
        try:
            found = await self._known.document(action.name, action.family)
            file, why = found["dock_database"], ""
            if file is not None and _full(Path(file)) == self._path:
                why = await self._servers.reload(found["node"], action.family, self._path)
        except Unavailable:
            return  # it reads the file when it starts, and is told when it is back
        if why:
            self._note(action.name, None if robot is None else robot.namespace, why)
            return
        self._faults.pop(action.name, None)
        self._told[action.name] = text

    def _note(self, key: str, robot: str | None, why: str) -> None:
        before = self._faults.get(key)
        if before is None or before.why != why:
            log.warning("the file of docks: %s", why)
        self._faults[key] = Fault(robot, utc_now() if before is None else before.since, why)

    def alerts(self) -> Iterator[Alert]:
        """Return what keeps a robot from the docks as they are."""
        for fault in self._faults.values():
            who = "The file of docks is not up to date" if fault.robot is None else f"{fault.robot} has old docks"
            detail = f"{fault.why.rstrip('.')}. Until that is mended, robots drive to the docks as they were."
            yield Alert(UNREAD, fault.robot, fault.since, who, detail)


def _full(path: Path) -> Path:
    return path.expanduser().absolute()

"""Sites that are stopped, and where a hub keeps which are."""

import asyncio
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import parse_qs

import orjson

from dock_gateway.core.errors import ServerTimeout, Unavailable
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant
from dock_hub.site_client import SiteRequest
from dock_hub.stop_requests import StopEntry
from dock_hub.stops import StopTimes
from tests.support.entries import EntriesInMemory

TIMES = StopTimes(answer_within=0.02, deadline=0.02, repeat_after=0.002)
BERLIN, OSLO = "berlin", "oslo"


@dataclass
class Answer:
    status: int
    body: bytes


@dataclass
class FakeSite:
    """A site whose answers are late or lost as a test likes."""

    robots: list[str]
    reachable: bool = True
    loses_answers: bool = False
    delay: float = 0.0
    gate: asyncio.Event | None = None  # what holds up the next requests
    held: int = 0  # requests that came to the gate
    refusal: Answer | None = None
    failed: list[dict[str, Any]] = field(default_factory=list)
    moving: list[str] = field(default_factory=list)  # not stopped
    others: list[dict[str, Any]] = field(default_factory=list)  # other gateways there
    warning: dict[str, Any] | None = None
    latched: bool = False
    stopped_at: str = "2026-11-30T12:00:00Z"
    by: str | None = None
    stops: int = 0
    asked: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)
    who: list[tuple[str | None, Grant]] = field(default_factory=list)
    waits: list[bytes | None] = field(default_factory=list)

    async def ask(self, request: SiteRequest) -> Answer:
        if self.delay > request.deadline:
            await asyncio.sleep(request.deadline)
            raise ServerTimeout("the site did not answer", code="site_timeout")
        if self.gate is not None:
            self.held += 1
            await self.gate.wait()
        await asyncio.sleep(self.delay)
        assert request.path == "/stop"
        self.who.append((request.user, request.grant))
        self.waits.append(dict(request.headers).get(b"prefer"))
        self.asked.append((request.method, tuple(parse_qs(request.query).get("robot", ()))))
        if self.refusal is not None:
            return self.refusal
        if request.method != "GET":
            self.latched = request.method == "POST"
        self.stops += request.method == "POST"
        if self.loses_answers:
            raise ServerTimeout("the site did not answer", code="site_timeout")
        held = self.robots if self.latched else []
        self.by = (orjson.loads(request.body)["by"] if request.body else self.by) if self.latched else None
        state = {"latched": self.latched, "stopped_at": (self.latched and self.stopped_at) or None, "by": self.by}
        state |= {"robots": held, "persisted": self.warning is None, "for_all": self.latched}
        state["stops"] = [{"robot": robot, "stopped_at": self.stopped_at, "by": self.by} for robot in held]
        report = {"stop": state, "failed": self.failed, "canceling": ["a"], "unconfirmed": ["/robot1/dock"]}
        report |= {"stopped": self.robots, "not_stopped": self.moving, "others": self.others, "warning": self.warning}
        return Answer(200, encode(report if request.method == "POST" else state))


class FakeSites:
    """Sites by name."""

    def __init__(self, *names: str) -> None:
        self.sites = {name: FakeSite(["/robot1", "/robot2"]) for name in names}

    def names(self) -> list[str]:
        return sorted(self.sites)

    def client(self, name: str) -> FakeSite:
        if not self.sites[name].reachable:
            raise Unavailable(f"the site {name} is not connected", code="site_unreachable")
        return self.sites[name]


class Store(EntriesInMemory[StopEntry]):
    """A database that may not answer."""

    down = False
    hold: asyncio.Event | None = None

    async def read(self) -> dict[str, StopEntry]:
        self._answer()
        if self.hold is not None:
            await self.hold.wait()
        return await super().read()

    async def write(self, key: str, entry: StopEntry | None, *_: Any) -> None:
        await asyncio.sleep(0)
        self._answer()
        await super().write(key, entry)

    def _answer(self) -> None:
        if self.down:
            raise Unavailable("the history does not answer", code="history_unavailable")

"""A gateway with an admin, to which requests are sent piece by piece."""

import asyncio
import re
from collections.abc import Awaitable, Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import orjson
from fastapi import FastAPI
from starlette.types import Message, Scope

from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.audit.record import RequestRecord
from dock_gateway.core.grant import Grant, Role
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from tests.support.audit import AuditList, audit_parts
from tests.support.history import HistoryInMemory
from tests.support.parts import Refusing
from tests.support.robot_actions import make_known_robots, make_robot_actions

PASSWORD = "correct horse battery staple"
Change = Callable[["Site"], Awaitable[Any]]


SETTINGS = Settings(authentication=True, database_url="sqlite:////nowhere", body_timeout=1.0)


@cache
def _app() -> FastAPI:
    """The application, which takes a while to make; the parts of a gateway come with each request."""
    return create_app(SETTINGS, Refusing(audit_parts()))


class Site:
    """A gateway with an admin, and nothing else; requests that are sent piece by piece."""

    def __init__(self) -> None:
        self.settings = SETTINGS
        self.history = history = HistoryInMemory()
        self.logins = Logins(history)
        self.audit = AuditList()
        self.secret = ""
        actions: Any = SimpleNamespace(goal=lambda _: None)
        self.parts = Refusing(
            {
                **audit_parts(),
                RequestRecord: self.audit,
                Settings: self.settings,
                History: history,
                Logins: self.logins,
                GoalDocuments: GoalDocuments(history),
                Quotas: Quotas(self.settings),
                Goals: Goals(actions, make_robot_actions(self.settings), history),
                KnownRobots: make_known_robots(history, "/"),
                RobotActions: SimpleNamespace(choose_actions=self._all_actions, homed_in=lambda _: frozenset()),
            }
        )
        self.app = _app()

    async def _all_actions(self, grant: Grant, group: str | None) -> None:
        return None

    async def open(self) -> "Site":
        await self.logins.accounts.add("root", Grant(Role.ADMIN), PASSWORD)
        await self.logins.accounts.add("ada", Grant(Role.ADMIN), PASSWORD)
        _, self.secret = await self.logins.log_in("ada", PASSWORD, "192.0.2.1")
        return self

    async def ask(
        self, method: str, template: str, body: bytes = b"{}", *, meanwhile: Change | None = None, **headers: str
    ) -> tuple[int, str | None]:
        """Send a request whose body comes in two pieces; `meanwhile` happens between them. Status and code."""
        pieces = [body[:1], body[1:]]
        sent: list[Message] = []

        async def receive() -> Message:
            if not pieces:
                await asyncio.Event().wait()
            piece = pieces.pop(0)
            if not pieces and meanwhile is not None:
                await meanwhile(self)
            return {"type": "http.request", "body": piece, "more_body": bool(pieces)}

        async def send(message: Message) -> None:
            sent.append(message)

        headers = {"content-length": str(len(body)), **headers}
        await self.app(self._scope(method, template, headers), receive, send)
        text = b"".join(message.get("body", b"") for message in sent)
        return sent[0]["status"], orjson.loads(text).get("code") if text else None

    async def read(self, path: str, *, after_a_piece: Change | None = None) -> bytes:
        """Read a file to its end, complete or not; something happens after its first piece."""
        pieces: list[bytes] = []

        asked = iter([{"type": "http.request", "body": b"", "more_body": False}])

        async def receive() -> Message:
            return next(asked, None) or await asyncio.get_running_loop().create_future()

        async def send(message: Message) -> None:
            pieces.append(message.get("body", b""))
            if len(pieces) == 2 and after_a_piece is not None:
                await after_a_piece(self)

        await self.app(self._scope("GET", path, {}), receive, send)
        return b"".join(pieces)

    def _scope(self, method: str, template: str, headers: dict[str, str]) -> Scope:
        ids = "00000000-0000-4000-8000-000000000000"
        path = re.sub(r"\{(\w+)(:path)?\}", lambda match: ids if match[1] == "goal_id" else "x1", template)
        given = {"host": "localhost", "authorization": f"Bearer {self.secret}", **headers}
        return {
            "type": "http",
            "http_version": "1.1",
            "method": method,
            "scheme": "http",
            "path": path,
            "raw_path": path.encode(),
            "query_string": b"",
            "headers": [(name.encode(), value.encode()) for name, value in given.items()],
            "client": ("192.0.2.1", 50000),
            "server": ("127.0.0.1", 8000),
            "state": {"parts": self.parts},
        }


async def log_out(site: Site) -> None:
    """End the login with which requests are sent."""
    await site.logins.log_out(site.secret)

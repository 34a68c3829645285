"""A gateway whose audit log is a list."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

from starlette.testclient import TestClient

from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.audit.record import RequestRecord
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.errors import Conflict, NotFound
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extension import Installed, extensions
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from tests.support.audit import AuditList
from tests.support.history import HistoryInMemory
from tests.support.robot_actions import make_known_robots

GOAL = "7d9c1c9e-0000-4000-8000-00000000000a"


class Site:
    """A gateway with a token for each role, which knows no robot."""

    def __init__(self, **settings: Any) -> None:
        self.history = HistoryInMemory()
        self.audit = AuditList()
        self.settings = Settings(database_url="sqlite:////nowhere", **settings)
        self.running: dict[str, str] = {GOAL: "/robot7/dock"}
        logins = Logins(self.history)
        self.secrets = asyncio.run(self._fill(logins))
        self.parts = Parts(
            {
                Settings: self.settings,
                Installed: extensions(),
                History: self.history,
                KnownRobots: make_known_robots(self.history, "/", "/robot7"),
                RequestRecord: self.audit,
                Subjects: Subjects(self.settings, self.running.get, lambda: ["/robot7"]),
                Logins: logins,
                Goals: SimpleNamespace(get=self._goal),
                Stopper: SimpleNamespace(release=self._release),
                Quotas: Quotas(self.settings),
                RobotRegistry: SimpleNamespace(get=self._no_robot),
            }
        )
        self._app = create_app(self.settings, self.parts)

    async def _fill(self, logins: Logins) -> dict[Role, str]:
        return {role: (await logins.create_token(role.value, Grant(role)))[1] for role in Role}

    async def _goal(self, goal_id: str, grant: Grant) -> Any:
        raise NotFound(f"there is no goal {goal_id}", code="goal_not_found")

    async def _release(self, robot: str | None) -> dict[str, Any]:
        if robot == "/broken":
            raise RuntimeError("a bug")
        if robot == "/busy":
            raise Conflict("busy", code="dock_busy")
        return {"robot": robot or "/", "latched": False, "stopped_at": None, "by": None, "namespace": None}

    def _no_robot(self, robot: str | None) -> Any:
        raise NotFound(f"there is no robot {robot}", code="robot_not_found")

    @contextmanager
    def client(self, role: Role | None = None) -> Iterator[TestClient]:
        headers = {} if role is None else {"Authorization": f"Bearer {self.secrets[role]}"}
        url, client = "http://127.0.0.1:8000", ("192.0.2.7", 50000)
        with TestClient(self._app, url, raise_server_exceptions=False, headers=headers, client=client) as http:
            yield http

    def one(self) -> AuditEntry:
        (entry,) = self.audit.entries
        self.audit.entries.clear()
        return entry

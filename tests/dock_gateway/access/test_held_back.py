"""A request whose body is held back acts with the login of the moment at which it acts."""

import asyncio
import re
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from datetime import datetime, timedelta
from types import SimpleNamespace
from typing import Any

import orjson
import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from starlette.types import Message, Scope

from dock_gateway.access import provider as provider_module
from dock_gateway.access.jwt import BEHIND
from dock_gateway.access.logins import Logins
from dock_gateway.access.single_sign_on import SingleSignOn
from dock_gateway.app import api_routers, create_app
from dock_gateway.audit.record import RequestRecord
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extension import extensions
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.operation import operation_of
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from tests.support.audit import AuditList, audit_parts
from tests.support.history import HistoryInMemory, make_goal
from tests.support.parts import Refusing
from tests.support.provider import FakeProvider, oidc_settings
from tests.support.robot_actions import make_robot_actions
from tests.support.waiting import until

CALLBACK = "https://robots.example/session/oidc/callback"
PASSWORD = "correct horse battery staple"
CHANGES = [
    (method, route.path, route.name)
    for router in api_routers(Settings(), extensions())
    for route in router.routes
    if isinstance(route, APIRoute)
    for method in route.methods
    if operation_of(route.endpoint).role is not None
]
Change = Callable[["Site"], Awaitable[Any]]

pytestmark = pytest.mark.usefixtures("quick_hashes")


class Site:
    """A gateway with an admin, and nothing else; requests that are sent piece by piece."""

    def __init__(self, sso: SingleSignOn | None = None) -> None:
        self.settings = Settings(authentication=True, database_url="sqlite:////nowhere", body_timeout=1.0)
        self.history = history = HistoryInMemory()
        self.logins = Logins(history, sso)
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
                Quotas: Quotas(self.settings),
                Goals: Goals(actions, make_robot_actions(self.settings), history),
                RobotActions: SimpleNamespace(choose_actions=self._all_actions, homed_in=lambda _: frozenset()),
            }
        )
        self.app: FastAPI = create_app(self.settings, self.parts)

    async def _all_actions(self, grant: Grant, group: str | None) -> None:
        return None

    async def open(self) -> "Site":
        await self.logins.add_user("root", Grant(Role.ADMIN), PASSWORD)
        await self.logins.add_user("ada", Grant(Role.ADMIN), PASSWORD)
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
    await site.logins.log_out(site.secret)


async def disable(site: Site) -> None:
    await site.logins.edit_user("ada", disabled=True)


async def remove(site: Site) -> None:
    await site.logins.remove_user("ada")


async def change_password(site: Site) -> None:
    await site.logins.edit_user("ada", password="another horse, another battery")


async def demote(site: Site) -> None:
    await site.logins.edit_user("ada", Grant(Role.VIEWER))


async def limit(site: Site) -> None:
    await site.logins.edit_user("ada", Grant(Role.OPERATOR, ("/robot7",)))


@pytest.mark.parametrize(("method", "path", "name"), CHANGES)
async def test_no_route_acts_for_a_login_that_ended_while_the_body_came(method: str, path: str, name: str) -> None:
    """Whichever the route: those that were let through find nothing, and answer otherwise."""
    site = await Site().open()
    answer = await site.ask(method, path, meanwhile=log_out)
    if name == "stop":  # carried out by its head
        assert answer[0] not in (401, 403)
        return
    assert answer == (401, "invalid_token")


@pytest.mark.parametrize(
    ("change", "answer"),
    [
        (log_out, (401, "invalid_token")),
        (disable, (401, "invalid_token")),
        (remove, (401, "invalid_token")),
        (change_password, (401, "invalid_token")),
        (demote, (403, "role_required")),
        (limit, (403, "role_required")),
    ],
)
@pytest.mark.parametrize(("method", "path"), [("PUT", "/users/{user}"), ("POST", "/tokens")])
async def test_what_changes_while_a_body_comes(change: Change, answer: tuple[int, str], method: str, path: str) -> None:
    site = await Site().open()
    body = {"name": "x", "role": "admin"} if method == "POST" else {"role": "admin", "password": PASSWORD}
    assert await site.ask(method, path, orjson.dumps(body), meanwhile=change) == answer
    assert {user["name"] for user in await site.logins.documents()} <= {"ada", "root"}
    assert await site.logins.tokens.documents() == []
    entry = site.audit.entries[-1]
    assert (entry.status, entry.code) == answer


async def test_a_limit_that_was_set_while_a_body_came() -> None:
    site = await Site().open()
    assert await site.ask("POST", "/actions/{name:graph_name}/goals", meanwhile=limit) == (403, "not_covered")


async def test_a_role_that_still_suffices() -> None:
    site = await Site().open()

    async def lower(site: Site) -> None:
        await site.logins.edit_user("ada", Grant(Role.OPERATOR))

    assert (await site.ask("POST", "/dock", meanwhile=lower))[0] == 404


async def test_a_token_that_expires_while_a_body_comes() -> None:
    site = await Site().open()
    expires_at = utc_now() + timedelta(seconds=0.2)
    _, site.secret = await site.logins.create_token("brief", Grant(Role.ADMIN), expires_at)

    async def expire(_: Site) -> None:
        await until(lambda: utc_now() >= expires_at)

    body = orjson.dumps({"role": "admin", "password": PASSWORD})
    assert await site.ask("PUT", "/users/{user}", body, meanwhile=expire) == (401, "invalid_token")


async def test_a_login_that_ends_while_the_password_is_hashed() -> None:
    """Others hash theirs first: the body was there long before."""
    site = await Site().open()
    others = [asyncio.create_task(site.logins.add_user(f"user{n}", Grant(Role.VIEWER), PASSWORD)) for n in range(50)]
    body = orjson.dumps({"role": "admin", "password": PASSWORD})
    change = asyncio.create_task(site.ask("PUT", "/users/{user}", body))
    await asyncio.sleep(0)
    await log_out(site)
    assert await change == (401, "invalid_token")
    await asyncio.gather(*others)
    assert "x1" not in {user["name"] for user in await site.logins.documents()}


async def test_the_record_says_when_it_acted() -> None:
    site = await Site().open()
    whole: list[datetime] = []

    async def note(_: Site) -> None:
        whole.append(utc_now())

    requests = [("PUT", "/users/{user}", {"role": "viewer", "password": PASSWORD}), ("POST", "/session", {"token": ""})]
    for method, path, body in requests:
        await site.ask(method, path, orjson.dumps(body), meanwhile=note)
        assert site.audit.entries[-1].at >= whole[-1]


async def test_a_body_is_asked_for_only_if_the_head_may_send_it() -> None:
    """As `Expect: 100-continue` has it: the server asks when the body is read for the first time."""
    site = await Site().open()

    async def never(_: Site) -> None:
        raise AssertionError("the body of a stranger was read")

    stranger = {"authorization": "Bearer dgw_x"}
    assert await site.ask("POST", "/dock", meanwhile=never, **stranger) == (401, "invalid_token")
    body = b"x" * (site.settings.max_body_bytes + 1)
    assert await site.ask("POST", "/dock", body, meanwhile=never) == (413, "body_too_large")


async def test_an_export_ends_with_the_login() -> None:
    """Its client cannot take the part for the whole."""
    site = await Site().open()
    for number in range(1200):
        site.history.record(make_goal(number))
    whole = await site.read("/goals/export")
    assert len(orjson.loads(whole)) == 1200
    part = await site.read("/goals/export", after_a_piece=log_out)
    assert 0 < len(part) < len(whole)
    with pytest.raises(orjson.JSONDecodeError):
        orjson.loads(part)


@pytest.fixture
async def people(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[tuple[Site, FakeProvider]]:
    """A site where admins of an identity provider log in."""
    fake = FakeProvider()
    fake.claims["roles"] = ["admins"]
    monkeypatch.setattr(provider_module, "_client", fake.client)
    site = Site(SingleSignOn(Settings(authentication=True, **oidc_settings(fake.issuer))))  # type: ignore[arg-type]
    yield site, fake
    await site.logins.close()


async def test_a_person_of_a_provider_who_is_logged_out_while_a_body_comes(people: tuple[Site, FakeProvider]) -> None:
    site, fake = people
    address, attempt = await site.logins.begin_person("/", CALLBACK)
    _, site.secret = await site.logins.log_in_person(attempt, fake.authorize(address), CALLBACK, "192.0.2.1")

    async def end(site: Site) -> None:
        await site.logins.end_person("oidc:ada")

    body = orjson.dumps({"name": "x", "role": "admin"})
    assert await site.ask("POST", "/tokens", body, meanwhile=end) == (401, "invalid_token")
    assert await site.logins.tokens.documents() == []


async def test_an_access_token_of_a_provider_that_expires_while_a_body_comes(
    people: tuple[Site, FakeProvider],
) -> None:
    site, fake = people
    expires = time.time() - BEHIND + 0.5
    site.secret = fake.access_token(exp=expires)

    async def expire(_: Site) -> None:
        await until(lambda: time.time() >= expires + BEHIND)

    body = orjson.dumps({"name": "x", "role": "admin"})
    assert await site.ask("POST", "/tokens", body, meanwhile=expire) == (401, "invalid_token")
    assert await site.logins.tokens.documents() == []
    site.secret = fake.access_token()
    assert await site.ask("POST", "/tokens", body) == (201, None)

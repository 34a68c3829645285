"""Users of a hub at a site: identified by what the tunnel has verified, with their role, and not for logins here."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest
from starlette.testclient import TestClient
from starlette.types import Receive, Scope, Send

from dock_gateway.access.logins import Logins
from dock_gateway.access.tickets import Tickets
from dock_gateway.app import create_app
from dock_gateway.core.access import Principal, PrincipalKind, forwarded
from dock_gateway.core.errors import Conflict
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.http.quotas import Quotas
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory
from tests.support.installed import needs
from tests.support.parts import Refusing
from tests.support.reachable import reachable

ALICE = forwarded("alice", Grant(Role.SUPERVISOR, ("/robot1",)).narrowed(Role.OPERATOR, ("/robot*",)), "key")


def through_the_hub(principal: Principal, *, authentication: bool = False) -> TestClient:
    """A client whose requests come as from the tunnel."""
    settings = Settings(authentication=authentication, database_url="sqlite:////nowhere")
    parts = {Settings: settings, Logins: Logins(HistoryInMemory()), Tickets: Tickets(), Quotas: Quotas(settings)}
    app = create_app(settings, Refusing({**audit_parts(), **parts, Bridge: SimpleNamespace(alive=False)}))

    async def tunnel(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "lifespan":
            scope["forwarded"] = principal
        await app(scope, receive, send)

    return TestClient(tunnel, "http://localhost", headers={"Sec-Fetch-Site": "cross-site"})


@pytest.mark.parametrize("authentication", [True, False])
def test_who_they_are_here(authentication: bool) -> None:
    with through_the_hub(ALICE, authentication=authentication) as client:
        session = client.get("/session").json()
    assert (session["required"], session["open_to"], session["hub"]) == (authentication, None, False)
    assert session["principal"] == {
        "name": "hub:alice",
        "kind": "hub",
        "role": "operator",
        "robots": ["/robot1"],
        "actions": [],
        "topics": [],
    }


@pytest.mark.parametrize("authentication", [True, False])
def test_a_role_counts_also_where_the_site_asks_nobody(authentication: bool) -> None:
    with through_the_hub(ALICE, authentication=authentication) as client:
        for method, path in (("GET", "/users"), ("POST", "/tokens"), ("PUT", "/users/x"), ("DELETE", "/stop")):
            answer = client.request(method, path)
            assert (answer.status_code, answer.json()["code"]) == (403, "role_required")


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/session"),
        ("DELETE", "/session"),
        ("POST", "/session/ticket"),
        pytest.param("GET", "/session/oidc", marks=needs("single_sign_on")),
    ],
)
def test_logins_are_not_for_a_hub(method: str, path: str) -> None:
    with through_the_hub(forwarded("root", UNLIMITED, "key")) as client:
        answer = client.request(method, path)
    assert (answer.status_code, answer.json()["code"]) == (403, "not_through_hub")
    assert "set-cookie" not in answer.headers


@needs("webhooks")
def test_webhooks_need_an_admin_of_the_hub() -> None:
    def answer(role: Role) -> Any:
        with through_the_hub(forwarded("eve", Grant(role), "key")) as client:
            return client.get("/webhooks").json()["code"]

    assert answer(Role.SUPERVISOR) == "not_through_hub"
    assert answer(Role.ADMIN) == "not_found"  # these parts have no notifier


def test_nobody_here_has_a_name_of_the_hub() -> None:
    async def refusals() -> None:
        logins = Logins(HistoryInMemory())
        for name in ("hub:alice", "Hub:alice", "hub"):
            with pytest.raises(Conflict, match="are reserved"):
                await logins.create_token(name, UNLIMITED)
            with pytest.raises(Conflict, match="are reserved"):
                await logins.accounts.add(name, UNLIMITED, "correct horse battery staple")

    asyncio.run(refusals())
    assert forwarded(None, UNLIMITED, "key").name == "hub"


def test_streams_are_watched_no_longer_than_they_last() -> None:
    logins = Logins(HistoryInMemory())
    assert logins.is_valid(ALICE)
    with logins.watch(ALICE, lambda: None), logins.watch(ALICE, lambda: None):
        assert ALICE in reachable(logins, Principal)
    assert reachable(logins, Principal) == []
    assert ALICE.kind is PrincipalKind.FORWARDED

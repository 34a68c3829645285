"""Every route and every command asks for a role, and for no other one; without a token there is next to nothing."""

import asyncio
import json
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest
from fastapi.routing import APIWebSocketRoute
from hypothesis import HealthCheck, given, settings
from starlette.testclient import TestClient, WebSocketDenialResponse, WebSocketTestSession

from dock_gateway.access.logins import Logins
from dock_gateway.access.tickets import Tickets
from dock_gateway.app import create_app
from dock_gateway.core.grant import Grant, Role
from dock_gateway.http.operation import operation_of
from dock_gateway.http.quotas import Quotas
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory
from tests.support.parts import Refusing
from tests.support.routes import REQUESTS, ROUTES_OF_API, path_of
from tests.support.shapes import check_answer
from tests.support.versions import STEPS, Resource, Step, require_that_nothing_is_lost

SOCKETS = [
    (route.path, operation_of(route.endpoint).role) for route in ROUTES_OF_API if isinstance(route, APIWebSocketRoute)
]
HTTPS = "https://127.0.0.1:8000"
PASSWORD = "correct horse battery staple"
OUT = {"required": True, "open_to": None, "principal": None, "provider": None, "hub": False, "share": []}

pytestmark = pytest.mark.usefixtures("quick_hashes", "stopped_clock")


class Site:
    """A gateway with a token for each role, and nothing else."""

    def __init__(self, settings: Settings) -> None:
        self.logins = Logins(HistoryInMemory())
        self.secrets = asyncio.run(self._fill()) if settings.authentication else {}
        parts = Refusing(
            {
                **audit_parts(),
                Settings: settings,
                Logins: self.logins,
                Tickets: Tickets(),
                Quotas: Quotas(settings),
                Bridge: SimpleNamespace(alive=False),
            }
        )
        self._app = create_app(settings, parts)

    def add_user(self, name: str, role: Role) -> None:
        asyncio.run(self.logins.accounts.add(name, Grant(role), PASSWORD))

    async def _fill(self) -> dict[Role, str]:
        return {role: (await self.logins.create_token(role.value, Grant(role)))[1] for role in Role}

    @contextmanager
    def client(self, role: Role | None = None, url: str = "http://127.0.0.1:8000") -> Iterator[TestClient]:
        headers = {} if role is None else {"Authorization": f"Bearer {self.secrets[role]}"}
        with TestClient(self._app, url, raise_server_exceptions=False, headers=headers) as client:
            yield client


SETTINGS = Settings(authentication=True, database_url="sqlite:////nowhere")


@pytest.fixture(scope="module")
def site() -> Site:
    return Site(SETTINGS)


@pytest.fixture
def users() -> Site:
    """A site with an operator, `ada`, who has a password."""
    site = Site(SETTINGS)
    site.add_user("ada", Role.OPERATOR)
    return site


def log_in(client: TestClient, user: str = "ada", password: str = PASSWORD) -> Any:
    return client.post("/session", json={"user": user, "password": password})


def described(name: str | None, kind: str, role: str, robots: list[str] | None = None) -> dict[str, Any]:
    """A principal, as the API shows it."""
    return {"name": name, "kind": kind, "role": role, "robots": robots or [], "actions": [], "topics": []}


def connect(client: TestClient, path: str, **options: Any) -> WebSocketTestSession:
    return client.websocket_connect(f"ws://127.0.0.1:8000{path}", **options)


def test_without_a_token_there_are_health_checks_and_the_login(site: Site) -> None:
    with site.client() as client:
        for method, template, operation in REQUESTS:
            answer = client.request(method, path_of(template))
            assert (answer.status_code == 401) is (operation.role is not None), (method, template)
            if operation.role is not None:
                assert answer.headers["www-authenticate"] == "Bearer"
                check_answer(method, template, 401, answer.headers["content-type"], answer.content)


@pytest.mark.parametrize("role", list(Role))
def test_each_role_may_do_what_is_declared(site: Site, role: Role) -> None:
    with site.client(role) as client:
        for method, template, operation in REQUESTS:
            allowed = operation.role is None or role.includes(operation.role)
            answer = client.request(method, path_of(template))
            assert (answer.status_code == 403) is not allowed, (method, template)


@pytest.mark.parametrize(("path", "role"), SOCKETS)
def test_a_socket_needs_a_token(site: Site, path: str, role: Role | None) -> None:
    assert role is Role.VIEWER
    with site.client() as client, pytest.raises(WebSocketDenialResponse) as denied, connect(client, path):
        pass
    assert denied.value.status_code == 401


@pytest.mark.parametrize("header", ["Basic YTpi", "Bearer", "Bearer ", "Bearer dgw_x", "dgw_x", "Bearer  "])
def test_other_credentials_are_refused(site: Site, header: str) -> None:
    with site.client() as client:
        assert client.get("/robots", headers={"Authorization": header}).status_code == 401


@pytest.mark.parametrize(("url", "cookie"), [("http://127.0.0.1:8000", "dock-gateway"), (HTTPS, "__Host-dock-gateway")])
def test_a_browser_logs_in_and_out(site: Site, url: str, cookie: str) -> None:
    secret = site.secrets[Role.OPERATOR]
    with site.client(url=url) as client:
        assert client.get("/session").json() == OUT
        assert client.post("/session", json={"token": "dgw_wrong"}).json()["code"] == "invalid_token"
        assert client.post("/session", json={"token": 7}).status_code == 422
        assert client.post("/session", json={}).status_code == 422
        assert not client.cookies
        answer = client.post("/session", json={"token": f" {secret}\n"})
        who = {
            "required": True,
            "open_to": None,
            "principal": described("operator", "token", "operator"),
            "provider": None,
            "hub": False,
            "share": [],
        }
        assert answer.json() == who
        attributes = answer.headers["set-cookie"].lower()
        assert attributes.startswith(f"{cookie.lower()}=")
        for attribute in ("httponly", "samesite=strict", "path=/"):
            assert attribute in attributes
        assert ("secure" in attributes) is (url == HTTPS)
        assert client.get("/session").json() == who
        assert client.get("/robots").status_code == 404
        assert client.delete("/session").json() == {
            "required": True,
            "open_to": None,
            "principal": None,
            "provider": None,
            "hub": False,
            "share": [],
        }
        assert not client.cookies
        assert client.get("/robots").status_code == 401


def test_a_ticket_opens_one_socket_for_the_one_who_asked(site: Site) -> None:
    with site.client(Role.VIEWER) as viewer:
        issued = viewer.post("/session/ticket")
        check_answer("POST", "/session/ticket", 201, "application/json", issued.content)
        assert issued.headers["cache-control"] == "no-store"
        ticket = issued.json()["ticket"]
    with site.client() as client:
        assert client.post("/session/ticket").status_code == 401
        assert client.get("/robots", params={"ticket": ticket}).status_code == 401
        assert denied(client, f"/ws/feedback?ticket={ticket}") == 404  # let through, but there is no robot
        assert denied(client, f"/ws/feedback?ticket={ticket}") == 401
        for secret in (site.secrets[Role.ADMIN], ""):
            assert denied(client, f"/ws/feedback?ticket={secret}") == 401
        assert denied(client, f"/ws/feedback?token={site.secrets[Role.ADMIN]}") == 401


def denied(client: TestClient, path: str) -> int:
    with pytest.raises(WebSocketDenialResponse) as refused, connect(client, path):
        pass
    code: int = refused.value.status_code
    return code


def test_tokens_over_http(site: Site) -> None:
    with site.client(Role.ADMIN) as admin:
        robots = ["/robot1", "/hall_a/*", "/robot1"]
        created = admin.post("/tokens", json={"name": "cron", "role": "operator", "days": 2, "robots": robots})
        assert created.status_code == 201
        assert created.headers["cache-control"] == "no-store"
        check_answer("POST", "/tokens", 201, "application/json", created.content)
        token = created.json()
        assert token["created_by"] == "admin"
        listed = admin.get("/tokens")
        check_answer("GET", "/tokens", 200, "application/json", listed.content)
        assert "secret" not in listed.text
        assert [each["name"] for each in listed.json()["tokens"]] == [
            "admin",
            "agent",
            "cron",
            "operator",
            "supervisor",
            "viewer",
        ]
        use = {"Authorization": f"Bearer {token['secret']}"}
        assert admin.get("/session", headers=use).json()["principal"] == described(
            "cron", "token", "operator", ["/robot1", "/hall_a/*"]
        )
        assert admin.post("/tokens", json={"name": "cron", "role": "viewer"}).json()["code"] == "token_exists"
        assert admin.delete(f"/tokens/{token['id']}").status_code == 204
        assert admin.get("/robots", headers=use).json()["code"] == "invalid_token"
        assert admin.delete(f"/tokens/{token['id']}").status_code == 204
        assert admin.get(f"/tokens/{token['id']}").json()["code"] == "token_not_found"


@pytest.mark.parametrize(
    ("body", "path"),
    [
        ({"name": "x", "role": "admin", "robots": ["/robot1"]}, "robots"),
        ({"name": "x", "role": "admin", "topics": ["/odom"]}, "topics"),
        ({"name": "x", "role": "viewer", "groups": []}, "groups"),
    ],
)
def test_what_is_no_token(site: Site, body: object, path: str) -> None:
    """Beyond what its schema says: see test_bodies.py."""
    with site.client(Role.ADMIN) as admin:
        answer = admin.post("/tokens", json=body)
    assert answer.status_code == 422
    assert [error["path"] for error in answer.json()["errors"]] == [path]


def test_without_authentication_everybody_may_do_everything() -> None:
    anybody = {
        "required": False,
        "open_to": "machine",
        "principal": described(None, "anybody", "admin"),
        "provider": None,
        "hub": False,
        "share": [],
    }
    with Site(Settings()).client() as client:
        assert client.get("/session").json() == anybody
        login = client.post("/session", json={"token": "dgw_x"})
        assert login.json() == anybody
        assert "set-cookie" not in login.headers
        assert client.delete("/session").json() == anybody
        assert client.get("/robots", headers={"Authorization": "Bearer dgw_x"}).status_code == 404


@pytest.mark.parametrize("url", ["http://127.0.0.1:8000", HTTPS])
def test_a_user_logs_in_and_out(users: Site, url: str) -> None:
    with users.client(url=url) as client:
        assert log_in(client, password="wrong").json()["code"] == "invalid_login"
        assert log_in(client, user="nobody").json()["code"] == "invalid_login"
        assert not client.cookies
        answer = log_in(client, " Ada ")
        who = {**OUT, "principal": described("ada", "user", "operator")}
        assert answer.json() == who
        for attributes, seconds in zip(answer.headers.get_list("set-cookie"), (2_592_000, 31_536_000), strict=True):
            for attribute in ("httponly", "samesite=strict", "path=/", f"max-age={seconds}"):
                assert attribute in attributes.lower()
            assert attributes.startswith("__Host-") is ("secure" in attributes.lower()) is (url == HTTPS)
        secret, browser = client.cookies.values()
        assert client.get("/session").json() == who
        assert client.delete("/session").json() == {
            "required": True,
            "open_to": None,
            "principal": None,
            "provider": None,
            "hub": False,
            "share": [],
        }
        assert list(client.cookies.values()) == [browser]  # what is no login stays
        for ended in (secret, browser):
            assert client.get("/robots", headers={"Authorization": f"Bearer {ended}"}).json()["code"] == "invalid_token"


def test_a_cookie_that_a_client_brings_is_never_adopted(users: Site) -> None:
    with users.client() as client:
        log_in(client)
        for brought in (client.cookies["dock-gateway"], "dgs_" + "x" * 43, ""):
            client.cookies.clear()
            client.headers["Cookie"] = f"dock-gateway={brought}"
            assert log_in(client).status_code == 200
            assert client.cookies["dock-gateway"].startswith("dgs_")
            assert client.cookies["dock-gateway"] != brought


def test_a_page_of_another_site_cannot_use_a_session(users: Site) -> None:
    foreign = {"Origin": "https://evil.example"}
    with users.client() as client:
        log_in(client)
        changes = [
            ("DELETE", "/session", None),
            ("DELETE", "/session?everywhere=true", None),
            ("PUT", "/session/password", {"old": PASSWORD, "new": "x" * 12}),
            ("POST", "/session", {"user": "ada", "password": PASSWORD}),
            ("PUT", "/users/eve", {"role": "admin", "password": "x" * 12}),
        ]
        for method, path, body in changes:
            answer = client.request(method, path, json=body, headers=foreign)
            assert answer.json()["code"] == "origin_not_allowed", path
            assert "set-cookie" not in answer.headers
        with pytest.raises(WebSocketDenialResponse) as denied, connect(client, "/ws", headers=foreign):
            pass
        assert denied.value.status_code == 403
        assert client.get("/session").json()["principal"]["name"] == "ada"


@pytest.mark.parametrize(
    ("body", "status", "path"),
    [
        ({"user": "ada"}, 422, "password"),
        ({"password": PASSWORD}, 422, "user"),
        ({"user": 7, "password": PASSWORD}, 422, "user"),
        ({"user": "x" * 61, "password": PASSWORD}, 422, "user"),
        ({"user": "ada", "password": ""}, 422, "password"),
        ({"user": "ada", "password": None}, 422, "password"),
        ({"user": "ada", "password": "x" * 201}, 422, "password"),
        ({"user": "ada", "password": "x" * 900_000}, 422, "password"),
        ({"user": "ada", "password": "\ud800"}, 400, None),
        ({"user": "ada", "password": "x", "token": "dgw_x"}, 422, "user"),
        ({"token": "x" * 1001}, 422, "token"),
        ([], 422, ""),
    ],
)
def test_what_is_no_login(users: Site, body: object, status: int, path: str | None) -> None:
    with users.client() as client:
        answer = client.post("/session", content=json.dumps(body))
        assert answer.status_code == status
        assert path is None or answer.json()["errors"][0]["path"] == path
        assert "x" * 12 not in answer.text
        assert client.post("/session", content=b'{"user": "ada", "password": "\xff"}').status_code == 400
        assert client.post("/session", content=b"x" * 1_100_000).status_code == 413


def test_after_failed_logins_the_next_one_has_to_wait(users: Site) -> None:
    with users.client() as client:
        for _ in range(5):
            assert log_in(client, password="wrong").status_code == 401
        refused = log_in(client)
        assert (refused.status_code, refused.json()["code"]) == (429, "too_many_logins")
        assert refused.headers["retry-after"] == str(refused.json()["retry_after"]) == "1"
        check_answer("POST", "/session", 429, refused.headers["content-type"], refused.content)


def test_the_own_password(users: Site) -> None:
    new = "another horse, another battery"
    with users.client() as client, users.client() as other:
        log_in(client)
        log_in(other)
        change = {"old": PASSWORD, "new": new}
        for body, path in (({"old": PASSWORD, "new": "x" * 11}, "new"), ({"new": new}, "old"), ({"old": ""}, "old")):
            answer = client.put("/session/password", json=body)
            assert (answer.status_code, answer.json()["errors"][0]["path"]) == (422, path)
        wrong = client.put("/session/password", json={**change, "old": "wrong"})
        assert (wrong.status_code, wrong.json()["code"]) == (403, "wrong_password")
        before = client.cookies["dock-gateway"]
        assert client.put("/session/password", json=change).status_code == 204
        assert client.cookies["dock-gateway"] != before
        assert client.get("/session").json()["principal"]["name"] == "ada"
        assert other.get("/session").json()["principal"] is None
        assert log_in(other, password=new).status_code == 200
        assert client.delete("/session?everywhere=true").json()["principal"] is None
        assert list(client.cookies) == ["dock-gateway-browser"]
        assert other.get("/session").json()["principal"] is None
    with users.client(Role.ADMIN) as script:
        for method, path, body in (("DELETE", "/session?everywhere=true", None), ("PUT", "/session/password", change)):
            assert script.request(method, path, json=body).json()["code"] == "user_required"


def test_users_over_http(users: Site) -> None:
    with users.client(Role.ADMIN) as admin, users.client() as client:
        missing = admin.put("/users/bob", json={"role": "viewer"})
        assert (missing.status_code, missing.json()["errors"][0]["path"]) == (422, "password")
        body = {"role": "operator", "robots": ["/hall_a/*"], "password": PASSWORD}
        created = admin.put("/users/bob", json=body)
        assert created.status_code == 201
        check_answer("PUT", "/users/{user}", 201, "application/json", created.content)
        assert created.json()["created_by"] == "admin"
        log_in(client, "bob")
        assert client.get("/session").json()["principal"] == described("bob", "user", "operator", ["/hall_a/*"])
        listed = admin.get("/users")
        check_answer("GET", "/users", 200, "application/json", listed.content)
        assert [(user["name"], user["sessions"]) for user in listed.json()["users"]] == [("ada", 0), ("bob", 1)]
        assert "argon2" not in listed.text
        changed = admin.put("/users/bob", json={"role": "viewer"})
        check_answer("PUT", "/users/{user}", 200, "application/json", changed.content)
        assert client.get("/session").json()["principal"] == described("bob", "user", "viewer")
        assert admin.put("/users/admin", json=body).json()["code"] == "token_exists"
        assert admin.post("/tokens", json={"name": "Bob", "role": "viewer"}).json()["code"] == "user_exists"
        assert admin.delete("/users/bob/sessions").status_code == 204
        assert client.get("/session").json()["principal"] is None
        assert admin.put("/users/bob", json={"role": "viewer", "disabled": True}).json()["disabled"] is True
        assert log_in(client, "bob").json()["code"] == "invalid_login"
        assert admin.delete("/users/bob").status_code == 204
        assert admin.delete("/users/bob").status_code == 204
        assert admin.get("/users/bob").json()["code"] == "user_not_found"
        assert admin.delete("/users/bob/sessions").json()["code"] == "user_not_found"


@pytest.mark.parametrize(
    ("name", "body", "path"),
    [
        ("bob", {"role": "viewer", "password": None}, "password"),
        ("bob", {"role": "admin", "robots": ["/robot1"]}, "robots"),
        ("Bob", {"role": "viewer"}, "user"),
        ("-bob", {"role": "viewer"}, "user"),
        ("b%20b", {"role": "viewer"}, "user"),
        ("b" * 61, {"role": "viewer"}, "user"),
    ],
)
def test_what_is_no_user(users: Site, name: str, body: object, path: str) -> None:
    """Beyond what its schema says: see test_bodies.py."""
    with users.client(Role.ADMIN) as admin:
        answer = admin.put(f"/users/{name}", json=body)
    assert answer.status_code == 422
    assert [error["path"] for error in answer.json()["errors"]] == [path]


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(steps=STEPS)
def test_of_two_admins_who_change_a_user_none_loses_a_change(users: Site, steps: list[tuple[Step, int]]) -> None:
    with users.client(Role.ADMIN) as admin:
        body = lambda each: {"role": "viewer", "robots": [f"/robot{each}"], "password": PASSWORD}  # noqa: E731
        number = lambda user: int(user["robots"][0].removeprefix("/robot"))  # noqa: E731
        require_that_nothing_is_lost(Resource(admin, "/users/eve", body, number), steps)


def test_what_a_user_does_makes_no_new_version(users: Site) -> None:
    with users.client(Role.ADMIN) as admin, users.client() as client:
        before = admin.get("/users/ada")
        log_in(client)
        after = admin.get("/users/ada")
        assert before.json()["logged_in_at"] != after.json()["logged_in_at"]
        assert before.headers["etag"] == after.headers["etag"]


def test_a_new_token_is_found_at_its_location(users: Site) -> None:
    with users.client(Role.ADMIN) as admin:
        created = admin.post("/tokens", json={"name": "cron", "role": "viewer"})
        path = created.headers["location"]
        shown = admin.get(path)
        assert shown.json() | {"secret": created.json()["secret"]} == created.json()
        assert shown.headers["etag"] == created.headers["etag"]
        assert admin.delete(path, headers={"If-Match": '"other"'}).json()["code"] == "changed_meanwhile"
        assert admin.delete(path, headers={"If-Match": shown.headers["etag"]}).status_code == 204
        assert admin.delete(path, headers={"If-Match": shown.headers["etag"]}).status_code == 204

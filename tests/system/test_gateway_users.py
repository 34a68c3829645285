"""Users of a real gateway: added on the command line, changed while their streams are open and their goals run."""

import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import orjson
import pytest

from tests.support.access import PASSWORD, Site, bearer, ends_with, log_in, stream, try_login
from tests.support.clients import HttpClient
from tests.support.gateway import LOW, RunningGateway, running_dock_server
from tests.support.installed import needs
from tests.support.postgresql import binaries, running_postgresql
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

INVALID_TOKEN = (4401, "invalid_token")
LOGINS = 15
OTHER = "another horse, another battery"
STREAMS = ("/ws/feedback", "/ws", "/ws/topics?topic=/battery_status")


@pytest.fixture
def site(tmp_path: Path) -> Site:
    site = Site(tmp_path)
    site.user("root", "admin")
    site.user("ada", "operator")
    return site


def status_of(gateway: RunningGateway, goal_id: str, secret: str) -> str:
    return str(gateway.http.get(f"/goals/{goal_id}", headers=bearer(secret)).raise_for_status().json()["status"])


def is_in(gateway: RunningGateway, secret: str) -> bool:
    return gateway.http.get("/robots", headers=bearer(secret)).status_code == 200


def test_what_changes_while_a_goal_runs(domain: int, site: Site) -> None:
    """Each change ends the streams; the goal goes on, and its user may do what they may now."""
    with running_dock_server(domain), site.gateway(domain) as gateway:
        gateway.wait_until_ready()
        http = gateway.http
        root, ada = bearer(log_in(gateway, "root")), log_in(gateway, "ada")
        http.put("/battery/publisher", json={"state": LOW, "rate_hz": 10}, headers=root).raise_for_status()
        goal = http.post("/dock", headers=bearer(ada)).raise_for_status().json()["goal_id"]

        with ExitStack() as stack:
            sockets = [stack.enter_context(stream(gateway, path, ada)) for path in STREAMS]
            http.put("/users/ada", json={"role": "viewer"}, headers=root).raise_for_status()
            assert http.post(f"/goals/{goal}/cancel", headers=bearer(ada)).json()["code"] == "role_required"
            assert [ends_with(socket) for socket in sockets] == [INVALID_TOKEN] * len(STREAMS)
        with stream(gateway, "/ws", ada) as socket:
            socket.send(orjson.dumps({"op": "cancel_goal", "id": "1", "goal_id": goal}).decode())
            assert orjson.loads(socket.recv())["error"]["code"] == "role_required"

        other = log_in(gateway, "ada")
        with stream(gateway, "/ws/feedback", ada) as first, stream(gateway, "/ws/feedback", other) as second:
            assert http.delete("/session?everywhere=true", headers=bearer(ada)).status_code == 200
            assert (ends_with(first), ends_with(second)) == (INVALID_TOKEN, INVALID_TOKEN)
        assert http.get("/robots", headers=bearer(other)).json()["code"] == "invalid_token"

        ada = log_in(gateway, "ada")
        with stream(gateway, "/ws/feedback", ada) as socket:
            assert site.run("user", "disable", "ada").returncode == 0
            assert ends_with(socket) == INVALID_TOKEN
        assert try_login(http, "ada").json()["code"] == "invalid_login"
        assert site.run("user", "enable", "ada").returncode == 0
        assert status_of(gateway, goal, log_in(gateway, "ada")) == "executing"
        http.post("/stop", headers=root).raise_for_status()


def test_sessions_survive_a_restart(shared_domain: int, site: Site) -> None:
    with site.gateway(shared_domain) as gateway:
        ada = log_in(gateway, "ada")
        ended = log_in(gateway, "ada")
        assert gateway.http.delete("/session", headers=bearer(ended)).status_code == 200
    with site.gateway(shared_domain) as gateway:
        assert gateway.http.get("/session", headers=bearer(ada)).json()["principal"]["name"] == "ada"
        assert gateway.http.get("/robots", headers=bearer(ended)).json()["code"] == "invalid_token"


def test_who_fails_at_the_same_address_locks_nobody_out(shared_domain: int, site: Site) -> None:
    """As behind one router: what counts is where a user has logged in before, by address and by browser."""
    with site.gateway(shared_domain) as gateway, HttpClient(gateway.url) as browser:
        browser.post("/session", json={"user": "root", "password": PASSWORD}).raise_for_status()
        assert {"dock-gateway", "dock-gateway-browser"} <= set(browser.cookies.keys())
        browser.delete("/session").raise_for_status()
        assert "dock-gateway-browser" in browser.cookies
        wrong = [try_login(gateway.http, "root", "wrong") for _ in range(8)]
        assert {answer.status_code for answer in wrong} == {401}
        assert try_login(gateway.http, "root").status_code == 200
        assert any(try_login(gateway.http, f"name{number}", "wrong").status_code == 429 for number in range(25))
        assert try_login(gateway.http, "root").status_code == 200
        assert browser.post("/session", json={"user": "root", "password": PASSWORD}).status_code == 200


@needs("audit_log")
def test_nobody_chooses_the_address_by_a_header(shared_domain: int, site: Site) -> None:
    secret = site.token("reader", "admin")
    with site.gateway(shared_domain, trusted_proxies="") as gateway:
        codes = [try_login(gateway.http, "ada", "wrong", f"198.51.100.{number}").status_code for number in range(10)]
        assert codes[:5] == [401] * 5
        assert 429 in codes[5:]
        entries = gateway.http.get("/audit", headers=bearer(secret)).raise_for_status().json()["records"]
        assert {entry["client"] for entry in entries} == {"127.0.0.1"}
        assert "X-Forwarded-For from 127.0.0.1 is ignored" in gateway.process.output


def test_a_stream_goes_on_during_logins(domain: int, site: Site) -> None:
    with running_dock_server(domain), site.gateway(domain) as gateway:
        gateway.wait_until_ready()
        root = log_in(gateway, "root")
        body = {"state": LOW, "rate_hz": 10}
        gateway.http.put("/battery/publisher", json=body, headers=bearer(root)).raise_for_status()
        gateway.http.post("/dock", headers=bearer(root)).raise_for_status()
        answers: list[int] = []

        def fail(number: int) -> None:
            with HttpClient(gateway.url) as http:
                answers.append(try_login(http, f"user{number}", "wrong", f"198.51.100.{number}").status_code)

        threads = [threading.Thread(target=fail, args=(number,)) for number in range(LOGINS)]
        with stream(gateway, "/ws/feedback", root) as socket:
            while orjson.loads(socket.recv())["type"] != "feedback":
                pass
            for thread in threads:
                thread.start()
            seen = 0
            while any(thread.is_alive() for thread in threads):
                seen += orjson.loads(socket.recv())["type"] == "feedback"
        assert answers == [401] * LOGINS
        assert seen >= 5
        gateway.http.post("/stop", headers=bearer(root)).raise_for_status()


def race_for_names(one: RunningGateway, other: RunningGateway, secret: str) -> None:
    """A user here and a token there with the same name, at the same moment: one of them is refused."""

    def add(name: str, outcomes: list[str]) -> None:
        with HttpClient(one.url) as http:
            body = {"role": "viewer", "password": PASSWORD}
            answer = http.put(f"/users/{name}", json=body, headers=bearer(secret))
            outcomes.append("user" if answer.status_code == 201 else answer.json()["code"])

    def create(name: str, outcomes: list[str]) -> None:
        with HttpClient(other.url) as http:
            answer = http.post("/tokens", json={"name": name.upper(), "role": "viewer"}, headers=bearer(secret))
            outcomes.append("token" if answer.status_code == 201 else answer.json()["code"])

    for number in range(4):
        outcomes: list[str] = []
        threads = [threading.Thread(target=each, args=(f"name{number}", outcomes)) for each in (add, create)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sorted(outcomes) in (["token", "token_exists"], ["user", "user_exists"])


def test_a_name_is_of_a_user_or_of_a_token(shared_domain: int, site: Site) -> None:
    secret = site.token("script", "admin")
    with site.gateway(shared_domain) as here, site.gateway(shared_domain) as elsewhere:
        race_for_names(here, elsewhere, secret)


def test_users_on_the_command_line(site: Site) -> None:
    short = site.run("user", "create", "bob", typed="too short\n")
    assert short.returncode == 2
    assert "12 to 200 characters" in short.output
    assert "user_exists" in site.run("user", "create", "ada", typed=PASSWORD).output
    assert "lower-case" in site.run("user", "create", "Bob", typed=PASSWORD).output
    assert "cannot be limited" in site.run("user", "create", "bob", "--role", "admin", "--robot", "/a").output
    site.user("bob", "operator", "--robot", "/hall_a/*")
    assert site.run("user", "passwd", "bob", typed=OTHER).returncode == 0
    assert site.run("user", "disable", "bob").returncode == 0
    listed = site.run("user", "list").output
    assert "operator    bob  (never logged in, disabled, only robots /hall_a/*)" in listed
    assert site.run("user", "delete", "bob").returncode == 0
    assert "bob" not in site.run("user", "list").output
    assert "user_not_found" in site.run("user", "enable", "bob").output
    assert "last_admin" in site.run("user", "disable", "root").output


@pytest.fixture(scope="module")
def postgresql() -> Iterator[str]:
    with running_postgresql() as server:
        yield server.url


@pytest.mark.skipif(binaries() is None, reason="no PostgreSQL is installed")
def test_two_gateways_on_one_database(domain: int, tmp_path: Path, postgresql: str) -> None:
    site = Site(tmp_path, postgresql)
    site.user("ada", "admin")
    with site.gateway(domain) as here, site.gateway(domain) as elsewhere:
        first, second = log_in(here, "ada"), log_in(here, "ada")
        wait_until(lambda: is_in(elsewhere, first) and is_in(elsewhere, second), "the sessions at the other gateway")
        race_for_names(here, elsewhere, first)
        with stream(elsewhere, "/ws/feedback", second) as socket:
            change = {"old": PASSWORD, "new": OTHER}
            changed = here.http.put("/session/password", json=change, headers=bearer(first)).raise_for_status()
            new = changed.cookies["dock-gateway"]
            here.http.cookies.clear()
            assert ends_with(socket) == INVALID_TOKEN
        assert (is_in(here, first), is_in(here, second), is_in(here, new)) == (False, False, True)
        wait_until(lambda: is_in(elsewhere, new), "the new session at the other gateway")
        assert try_login(elsewhere.http, "ada").json()["code"] == "invalid_login"
        assert is_in(elsewhere, log_in(elsewhere, "ada", OTHER))

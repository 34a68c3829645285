"""Requests of a real gateway that go on while their login ends: held-back bodies, waits."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import orjson
import pytest

from tests.support.access import PASSWORD, Site, bearer, log_in, try_login
from tests.support.clients import HttpClient
from tests.support.gateway import LOW, RunningGateway, running_dock_server
from tests.support.installed import needs
from tests.support.waiting import PATIENCE, wait_until

pytestmark = [needs("audit_log"), pytest.mark.ros]


@pytest.fixture
def site(tmp_path: Path) -> Site:
    site = Site(tmp_path)
    site.user("root", "admin")
    return site


def head_of(method: str, path: str, secret: str, size: int, *headers: str) -> bytes:
    lines = [f"{method} {path} HTTP/1.1", "Host: localhost", f"Authorization: Bearer {secret}", *headers]
    return "\r\n".join([*lines, "Content-Type: application/json", f"Content-Length: {size}", "", ""]).encode()


@contextmanager
def connected(gateway: RunningGateway) -> Iterator[socket.socket]:
    address = urlsplit(gateway.url)
    with socket.create_connection((address.hostname, address.port), timeout=PATIENCE) as connection:
        yield connection


def read_answer(connection: socket.socket) -> tuple[int, dict[str, Any]]:
    """Status and body of an answer with a `Content-Length`."""
    answer = b""
    while b"\r\n\r\n" not in answer:
        answer += connection.recv(65536)
    head, _, body = answer.partition(b"\r\n\r\n")
    size = int(next(line for line in head.lower().split(b"\r\n") if line.startswith(b"content-length")).split(b":")[1])
    while len(body) < size:
        body += connection.recv(65536)
    return int(head.split(b" ")[1]), orjson.loads(body or b"{}")


def hold_back(
    gateway: RunningGateway, request: tuple[str, str, Any], secret: str, meanwhile: Callable[[], object]
) -> tuple[int, Any]:
    """Send a head and three bytes, then, after something else, the rest. Status and code of the answer."""
    method, path, body = request
    data = orjson.dumps(body)
    with connected(gateway) as connection:
        connection.sendall(head_of(method, path, secret, len(data)) + data[:3])
        meanwhile()
        connection.sendall(data[3:])
        status, document = read_answer(connection)
    return status, document.get("code")


def test_a_body_that_is_held_back_until_the_token_is_revoked(domain: int, site: Site) -> None:
    with running_dock_server(domain), site.gateway(domain) as gateway:
        gateway.wait_until_ready()
        http, root = gateway.http, bearer(log_in(gateway, "root"))

        def token() -> tuple[str, Callable[[], None]]:
            answer = http.post("/tokens", json={"name": "brief", "role": "admin"}, headers=root)
            created = answer.raise_for_status().json()

            def revoke() -> None:
                revoked.append(datetime.now(UTC))
                assert http.delete(f"/tokens/{created['id']}", headers=root).status_code == 204

            return created["secret"], revoke

        revoked: list[datetime] = []
        requests: list[tuple[str, str, Any]] = [
            ("PUT", "/users/eve", {"role": "admin", "password": PASSWORD}),
            ("POST", "/tokens", {"name": "another", "role": "admin"}),
            ("POST", "/dock", {"desired_battery_state": {"power_supply_status": 1}}),
            ("POST", "/battery", {"percentage": 0.5}),
        ]
        for request in requests:
            assert hold_back(gateway, request, token()[0], lambda: None)[0] < 300, request
            http.post("/stop", json={"latch": False}, headers=root).raise_for_status()
            (brief,) = [each for each in tokens(http, root) if each["name"] == "brief"]
            http.delete(f"/tokens/{brief['id']}", headers=root).raise_for_status()
        for each in tokens(http, root):
            http.delete(f"/tokens/{each['id']}", headers=root).raise_for_status()
        http.delete("/users/eve", headers=root).raise_for_status()
        goals = len(http.get("/goals", headers=root).json()["goals"])

        for request in requests:
            secret, revoke = token()
            assert hold_back(gateway, request, secret, revoke) == (401, "invalid_token"), request
            record = wait_until(lambda: refusals(http, root, revoked[-1]), "the record")[0]
            assert (record["status"], record["code"]) == (401, "invalid_token")
        assert try_login(http, "eve").json()["code"] == "invalid_login"
        assert tokens(http, root) == []
        assert len(http.get("/goals", headers=root).json()["goals"]) == goals


def refusals(http: HttpClient, headers: dict[str, str], since: datetime) -> list[dict[str, Any]]:
    """Records of what was refused, newest first, by the time at which it would have acted."""
    query = {"outcome": "refused", "since": since.isoformat()}
    found: list[dict[str, Any]] = http.get("/audit", params=query, headers=headers).raise_for_status().json()["records"]
    return found


def tokens(http: HttpClient, headers: dict[str, str]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = http.get("/tokens", headers=headers).raise_for_status().json()["tokens"]
    return found


def test_a_stop_whose_login_ends_while_its_body_comes_is_carried_out(shared_domain: int, site: Site) -> None:
    """It has stopped before: everyone who could stop when the head came has stopped."""
    secret = site.token("viewer", "viewer")
    with site.gateway(shared_domain) as gateway:
        http, root = gateway.http, bearer(log_in(gateway, "root"))

        def revoke() -> None:
            (token,) = tokens(http, root)
            assert http.delete(f"/tokens/{token['id']}", headers=root).status_code == 204

        assert hold_back(gateway, ("POST", "/stop", {"latch": True}), secret, revoke) == (200, None)
        assert http.get("/stop", headers=root).json()["by"] == "viewer"
        assert hold_back(gateway, ("POST", "/stop", {}), secret, lambda: None) == (401, "invalid_token")
        http.delete("/stop", headers=root).raise_for_status()


def test_a_wait_for_the_end_of_a_goal_ends_with_the_login_and_the_goal_goes_on(domain: int, site: Site) -> None:
    secret = site.token("cron", "operator")
    with running_dock_server(domain), site.gateway(domain) as gateway:
        gateway.wait_until_ready()
        http, root = gateway.http, bearer(log_in(gateway, "root"))
        http.put("/battery/publisher", json={"state": LOW, "rate_hz": 10}, headers=root).raise_for_status()
        answers: list[Any] = []

        def wait() -> None:
            with HttpClient(gateway.url) as client:
                answers.append(client.post("/dock", headers={**bearer(secret), "Prefer": "wait=300"}))

        waiting = threading.Thread(target=wait)
        waiting.start()
        running = "/dock?status=executing"
        goal = wait_until(lambda: http.get(running, headers=root).raise_for_status().json()["goals"], "the goal")[0]
        (token,) = tokens(http, root)
        assert http.delete(f"/tokens/{token['id']}", headers=root).status_code == 204
        waiting.join(PATIENCE)
        (answer,) = answers
        assert (answer.status_code, answer.json()["code"]) == (401, "invalid_token")
        assert answer.json()["goal_id"] == goal["goal_id"]
        assert http.get(f"/goals/{goal['goal_id']}", headers=root).json()["status"] == "executing"
        http.post("/stop", headers=root).raise_for_status()


def test_a_goal_that_waits_for_its_server_is_not_sent_once_the_login_has_ended(domain: int, site: Site) -> None:
    secret = site.token("cron", "operator")
    with site.gateway(domain, server_wait="60") as gateway:
        http, root = gateway.http, bearer(log_in(gateway, "root"))
        answers: list[Any] = []

        def send() -> None:
            with HttpClient(gateway.url) as client:
                answers.append(client.post("/dock", headers=bearer(secret)))

        sending = threading.Thread(target=send)
        sending.start()
        wait_until(lambda: "requests_in_progress 2" in http.get("/metrics", headers=root).text, "the request")
        (token,) = tokens(http, root)
        assert http.delete(f"/tokens/{token['id']}", headers=root).status_code == 204
        with running_dock_server(domain):
            sending.join(PATIENCE)
            (answer,) = answers
            assert (answer.status_code, answer.json()["code"]) == (401, "invalid_token")
            assert http.get("/goals", headers=root).json()["goals"] == []


def test_clients_that_ask_before_they_send_the_body(shared_domain: int, site: Site) -> None:
    """`Expect: 100-continue`, as curl sends it with a large body: nobody asks a stranger for one."""
    secret = site.token("ada", "admin")
    body = orjson.dumps({"name": "another", "role": "viewer"})
    with site.gateway(shared_domain) as gateway:
        with connected(gateway) as connection:
            connection.sendall(head_of("POST", "/tokens", "dgw_wrong", len(body), "Expect: 100-continue"))
            assert read_answer(connection)[0] == 401
        with connected(gateway) as connection:
            connection.sendall(head_of("POST", "/tokens", secret, len(body), "Expect: 100-continue"))
            assert connection.recv(65536).startswith(b"HTTP/1.1 100 ")
            connection.sendall(body)
            assert read_answer(connection)[0] == 201

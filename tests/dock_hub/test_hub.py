"""A hub that asks for a login, with a small site, over a real NATS server."""

import asyncio
import re
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any
from uuid import UUID

import orjson
import pytest
import websockets.asyncio.client
from websockets.exceptions import ConnectionClosed, InvalidStatus

from dock_gateway.access.logins import Logins
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extension import Installed
from dock_gateway.http.quotas import Quotas
from dock_gateway.sites import subjects
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.messages import Hello, Refusal, Welcome
from dock_gateway.sites.tunnel import channel
from dock_gateway.sites.tunnel.channel import Timing
from dock_hub import directory, forwarding, overview
from dock_hub.directory import SiteState
from dock_hub.sites import Sites
from tests.support.installed import needs
from tests.support.nats import NatsServer, nats_server
from tests.support.open_hub import Hub, hub_at
from tests.support.small_site import ALERT, broker_of, say_hello, small_site
from tests.support.waiting import until


@pytest.fixture(scope="module")
def nats(tmp_path_factory: pytest.TempPathFactory) -> Iterator[NatsServer]:
    with nats_server(tmp_path_factory.mktemp("nats")) as server:
        yield server


@pytest.fixture
async def hub(nats: NatsServer, tmp_path: Path) -> AsyncIterator[Hub]:
    """A hub with the site berlin."""
    signer = Signer.load_or_create(tmp_path / "hub.key")
    async with hub_at(nats.url, tmp_path) as hub, small_site(nats.url, signer, tmp_path):
        await hub.connected("berlin")
        yield hub


async def test_the_site_learns_who_asks_and_nothing_of_the_login(hub: Hub) -> None:
    _, header = await hub.token("ada", Role.OPERATOR, "/berlin/hall_a/*", "/oslo/*")
    said = {"Cookie": "a=b", "X-Request-ID": "mine", "X-Forwarded-For": "1.2.3.4", **header}
    answer = await hub.http.post("/sites/berlin/echo?robot=/r1", content=b"{}", headers=said)
    asked: dict[str, Any] = answer.json()
    assert (asked["name"], asked["role"], asked["robots"]) == ("ada", "operator", ["/hall_a/*"])
    assert (asked["query"], asked["body"]) == ("robot=/r1", "{}")
    assert len(asked["headers"]["idempotency-key"]) == 32
    assert asked["headers"].keys() & {"authorization", "cookie", "x-forwarded-for", "origin"} == set()
    moved = await hub.http.post("/sites/berlin/elsewhere", headers=header)
    assert (moved.status_code, moved.headers["location"]) == (202, "/sites/berlin/echo")
    assert "set-cookie" not in moved.headers


@needs("sites")
async def test_every_metric_of_a_hub_is_documented(hub: Hub) -> None:
    _, header = await hub.token("prometheus", Role.VIEWER)
    answer = (await hub.http.get("/metrics", headers=header)).raise_for_status()
    page = (Path(__file__).parents[2] / "docs" / "extensions" / "sites.md").read_text()
    named = set(re.findall(r"^\| `(dock_gateway_\w+)` \| (\w+) \|", page, re.MULTILINE))
    told = set(re.findall(r"^# TYPE (dock_gateway_(?:site|broker)\w+) (\w+)$", answer.text, re.MULTILINE))
    assert len(told) == 5
    assert named == told


async def test_what_a_login_does_not_reach_is_not_there(hub: Hub) -> None:
    _, header = await hub.token("eve", Role.ADMIN, "/oslo/*")
    assert (await hub.http.get("/sites", headers=header)).json()["sites"] == []
    for path in ("/sites/berlin", "/sites/berlin/echo", "/sites/paris/echo"):
        assert (await hub.http.get(path, headers=header)).json()["code"] == "site_not_found", path
    docking = (await hub.http.post("/dock", headers=header)).json()
    assert docking["detail"].endswith("what belongs to one site is at /sites/{site}/…")
    assert (await hub.http.get("/sites/berlin/echo")).json()["code"] == "not_authenticated"
    address = f"{hub.url.replace('http', 'ws')}/ws/feedback?include=fleet"
    async with websockets.asyncio.client.connect(address, additional_headers=header) as socket:
        snapshot = orjson.loads(await socket.recv())
        assert (snapshot["robots"], snapshot["sites"]) == ([], [])
    foreign = {"Origin": "https://evil.example", **header}
    assert (await hub.http.post("/sites/berlin/echo", headers=foreign)).json()["code"] == "origin_not_allowed"


@pytest.mark.parametrize("prefer", [{}, {"Prefer": "wait=300"}])
async def test_a_site_that_works_on_a_request_is_waited_for(
    prefer: dict[str, str], hub: Hub, nats: NatsServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For a person who has to allow a goal, for example: only the site knows for how long."""
    monkeypatch.setattr(forwarding, "DEADLINE", 0.4)
    _, header = await hub.token("ada", Role.OPERATOR)
    signer, timing = Signer.load_or_create(tmp_path / "hub.key"), Timing(alive=0.1, silence=15)
    async with small_site(nats.url, signer, tmp_path, "turin", timing):
        await hub.connected("turin")
        answer = await hub.http.post("/sites/turin/slow?seconds=1.5", headers=prefer | header)
        assert (answer.status_code, answer.json()) == (200, {"waited": True})


async def test_no_site_is_waited_for_without_end(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(channel, "LONGEST_WAIT", 0.2)
    _, header = await hub.token("ada", Role.OPERATOR)
    answer = await hub.http.post("/sites/berlin/never", headers=header)
    assert (answer.status_code, answer.json()["code"]) == (504, "site_timeout")


async def test_a_site_that_shows_no_sign_of_life_until_it_answers(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forwarding, "DEADLINE", 0.2)
    _, header = await hub.token("ada", Role.OPERATOR)
    answer = await hub.http.post("/sites/berlin/never", headers={"Idempotency-Key": "mine", **header})
    problem = answer.json()
    assert (problem["status"], problem["code"], problem["idempotency_key"]) == (504, "site_timeout", "mine")
    made = (await hub.http.post("/sites/berlin/never", headers=header)).json()["idempotency_key"]
    assert len(made) == 32


async def test_a_stream_through_the_hub_ends_with_the_login(hub: Hub) -> None:
    token_id, header = await hub.token("ada", Role.VIEWER)
    ticket = (await hub.http.post("/session/ticket", headers=header)).json()["ticket"]
    address = f"{hub.url.replace('http', 'ws')}/sites/berlin/ws/feedback"
    with pytest.raises(InvalidStatus) as refused:
        await websockets.asyncio.client.connect(address)
    assert refused.value.response.status_code == 401
    async with websockets.asyncio.client.connect(f"{address}?ticket={ticket}") as socket:
        assert '"snapshot"' in str(await socket.recv())
        await socket.send("hello")
        assert await socket.recv() == "hello"
        await hub.parts[Logins].revoke_token(token_id)
        with pytest.raises(ConnectionClosed) as closed:
            await socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 4401


@needs("audit_log")
async def test_each_socket_that_does_not_only_read_is_in_the_audit_log(hub: Hub) -> None:
    _, header = await hub.token("ada", Role.ADMIN)
    for path in ("ws/feedback", "ws", "a_new_door"):
        address = f"{hub.url.replace('http', 'ws')}/sites/berlin/{path}"
        async with websockets.asyncio.client.connect(address, additional_headers=header) as socket:
            await socket.recv()
    records: list[dict[str, Any]] = []
    while len(records) < 2:  # they are written a little later
        answer = await hub.http.get("/audit?what=forward_websocket", headers=header)
        records = answer.json()["records"]
    recorded = sorted((each["subject"], each["principal"]) for each in records)
    assert recorded == [("/sites/berlin/a_new_door", "ada"), ("/sites/berlin/ws", "ada")]


def test_the_sockets_that_only_read_are_those_of_a_gateway() -> None:
    lines = (Path(__file__).parents[1] / "dock_gateway/http/operations.txt").read_text().splitlines()
    assert {f"WebSocket /{path}" for path in forwarding.READING} <= {" ".join(line.split()[:2]) for line in lines}


async def test_robots_of_a_site_stay_as_they_were_when_it_leaves(hub: Hub, nats: NatsServer, tmp_path: Path) -> None:
    _, header = await hub.token("ada", Role.VIEWER, "/turin/*")
    address = f"{hub.url.replace('http', 'ws')}/ws/feedback?include=fleet"
    async with small_site(nats.url, Signer.load_or_create(tmp_path / "hub.key"), tmp_path, "turin"):
        await hub.connected("turin")
        shown = (await hub.http.get("/robots", headers=header)).json()["robots"]
        assert [(robot["name"], robot["site"], robot["site_state"]) for robot in shown] == [
            ("/turin/robot1", "turin", "connected")
        ]
        socket = await websockets.asyncio.client.connect(address, additional_headers=header)
        snapshot = orjson.loads(await socket.recv())
        assert [site["name"] for site in snapshot["sites"]] == ["turin"]
        assert [robot["name"] for robot in snapshot["robots"]] == ["/turin/robot1"]
    robots = sites = None
    while robots is None or sites is None:
        event = orjson.loads(await socket.recv())
        if event["type"] == "robots" and event["robots"][0]["site_state"] == "unreachable":
            robots = event["robots"]
        if event["type"] == "sites" and event["sites"][0]["state"] == "unreachable":
            sites = event["sites"]
    await socket.close()
    assert robots == [shown[0] | {"site_state": "unreachable", "join": None}]
    assert [(site["name"], site["stop"]["robots"]) for site in sites] == [("turin", ["/turin/robot1"])]


async def test_an_extension_that_fails_is_an_alert(nats: NatsServer, tmp_path: Path) -> None:
    installed = Installed([], {"statistics": ImportError("no module named numpy")})
    async with hub_at(nats.url, tmp_path, installed) as hub:
        _, header = await hub.token("ada", Role.OPERATOR)
        await until(hub.parts[overview.Overview].documents)
        (alert,) = (await hub.http.get("/alerts", headers=header)).json()["alerts"]
        assert (alert["kind"], alert["robot"], alert["title"]) == ("extension_failed", None, "No statistics")
        assert (await hub.http.get("/statistics", headers=header)).status_code == 404


async def test_alerts_are_acknowledged_where_they_belong(
    hub: Hub, nats: NatsServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, header = await hub.token("ada", Role.OPERATOR)
    monkeypatch.setattr(overview, "SILENT_AFTER", 0.0)
    async with small_site(nats.url, Signer.load_or_create(tmp_path / "hub.key"), tmp_path, "turin"):
        await hub.connected("turin")
    shown = hub.parts[overview.Overview]
    await until(lambda: "site_unreachable" in {alert["kind"] for alert in shown.documents()})
    found = {alert["kind"]: alert for alert in (await hub.http.get("/alerts", headers=header)).json()["alerts"]}
    assert found["site_unreachable"]["robot"] == "/turin"
    asked = {
        "site_unreachable": (found["site_unreachable"]["id"], "ada"),
        "low_battery": (f"berlin.{ALERT['id']}", "ada, as ada"),
    }
    for alert_id, by in asked.values():
        answer = await hub.http.put(f"/alerts/{alert_id}/acknowledgement", json={"by": "x"}, headers=header)
        assert answer.json()["acknowledged"]["by"] == by
    away = await hub.http.put(f"/alerts/turin.{ALERT['id']}/acknowledgement", json={"by": "x"}, headers=header)
    assert away.json()["code"] == "site_unreachable"


async def test_who_is_welcome(hub: Hub, nats: NatsServer) -> None:
    _, header = await hub.token("root", Role.ADMIN)
    async with broker_of(nats.url, "oslo") as broker:
        first, second = (f"{number:016x}" for number in (1, 2))
        assert isinstance(await say_hello(broker, "oslo", first), Welcome)
        taken = await say_hello(broker, "oslo", second, installation=2)
        assert isinstance(taken, Refusal)
        assert taken.code == "site_name_taken"
        # Nobody listens to the first process, so it is gone.
        assert isinstance(await say_hello(broker, "oslo", second), Welcome)
        assert isinstance(await say_hello(broker, "oslo", second, leaving=True), Welcome)
        await until(lambda: hub.parts[Sites].state("oslo") is not SiteState.CONNECTED)
        site = (await hub.http.get("/sites/oslo", headers=header)).json()
        assert site["refused"] == {"site_name_taken": 1, "site_connected_elsewhere": 1}
        assert (await hub.http.post("/sites/oslo/echo", headers=header)).json()["code"] == "site_unreachable"
        assert (await hub.http.delete("/sites/oslo", headers=header)).status_code == 204
        assert isinstance(await say_hello(broker, "oslo", first, installation=2), Welcome)


async def test_an_acknowledgement_that_a_site_answers_with_nonsense(hub: Hub) -> None:
    _, header = await hub.token("ada", Role.OPERATOR)
    alert = {"id": "berlin.1", "robot": "/berlin", "severity": "critical", "started_at": "2026-11-27T12:00:00Z"}
    hub.parts[Sites].view("berlin").put_alerts([alert])
    answer = await hub.http.delete("/alerts/berlin.1/acknowledgement", headers=header)
    assert (answer.status_code, answer.json()["code"]) == (502, "site_failed")


async def test_a_gateway_that_never_was_welcome_is_forgotten(
    hub: Hub, nats: NatsServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    hello = Hello(installation=UUID(int=9), instance="0" * 16, version="99.0", at=0)
    async with broker_of(nats.url, "paris") as broker:
        await broker.request(subjects.hello("paris"), hello.encode(), 60)
    assert hub.parts[Sites].names() == ["berlin", "paris"]
    monkeypatch.setattr(directory, "SILENT_AFTER", 0.0)
    await until(lambda: hub.parts[Sites].names() == ["berlin"])


async def test_a_stop_of_a_site_is_carried_whatever_its_request_is_like(hub: Hub) -> None:
    """What the site would refuse as a message is left out: the stop is not."""
    _, header = await hub.token("ada", Role.VIEWER)
    host, port = hub.url.removeprefix("http://").split(":")
    many = "".join(f"x-{number}: 1\r\n" for number in range(95))
    for query, more in (("robot=/%C3%BC", ""), ("robot=/r1", many), ("a=%", f"x-{'y' * 300}: 1\r\n")):
        reader, writer = await asyncio.open_connection(host, int(port))
        head = f"POST /sites/berlin/stop?{query} HTTP/1.1\r\nhost: localhost\r\n{more}content-length: 0\r\n"
        login = "".join(f"{name}: {value}\r\n" for name, value in header.items())
        writer.write(f"{head}{login}connection: close\r\n\r\n".encode())
        answer = await reader.read()
        assert b'"stopped"' in answer, answer
        writer.close()


async def test_a_stop_of_a_site_is_one_however_it_is_written(hub: Hub) -> None:
    """It needs no place and does not wait for its body, like a stop at a gateway; no other request is one."""
    _, header = await hub.token("ada", Role.VIEWER)
    host, port = hub.url.removeprefix("http://").split(":")
    login = "".join(f"{name}: {value}\r\n" for name, value in header.items())
    with ExitStack() as places:
        ada = Principal("ada", "token", Grant(Role.VIEWER), None)
        with suppress(TooManyRequests):
            while True:
                places.enter_context(hub.parts[Quotas].slot(ada, "requests of one", per="berlin"))
        echo = await hub.http.post("/sites/berlin/echo", headers=header)
        assert (echo.status_code, echo.json()["code"]) == (429, "too_many_streams")
        for below in ("/STOP", "//stop", "/stop;x", "/stop/", "/%73top", "/./stop", "/x/../stop", "/stop#"):
            for method in ("POST", "post"):
                reader, writer = await asyncio.open_connection(host, int(port))
                head = f"{method} /sites/berlin{below} HTTP/1.1\r\nhost: localhost\r\ncontent-length: 9\r\n"
                writer.write(f"{head}{login}connection: close\r\n\r\n".encode())  # the body never comes
                async with asyncio.timeout(5):
                    answer = await reader.read()
                assert answer.startswith(b"HTTP/1.1 200 "), (below, answer)
                assert b'"stopped"' in answer
                writer.close()


async def test_everyone_may_stop_every_site(hub: Hub) -> None:
    """Also who is limited to robots of other sites, and sees none of this one."""
    for name, robots, seen in (("ada", "/hamburg", False), ("ben", "/berlin/robot2", False), ("eve", "/berlin", True)):
        _, header = await hub.token(name, Role.VIEWER, robots)
        answer = await hub.http.post("/sites/berlin/stop", headers=header)
        assert (answer.status_code, answer.json()) == (200, {"stopped": [], "name": name, "seen": seen})
    _, header = await hub.token("ada2", Role.ADMIN, "/hamburg")
    for method, path in (("DELETE", "stop"), ("GET", "stop"), ("POST", "echo")):
        answer = await hub.http.request(method, f"/sites/berlin/{path}", headers=header)
        assert answer.json()["code"] == "site_not_found", (method, path)

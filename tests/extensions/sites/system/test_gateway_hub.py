"""A site and its hub: a real gateway, a real NATS server, and a small hub that asks as a hub does."""

import asyncio
import re
import signal
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import orjson
import pytest
import pytest_asyncio

from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.messages import Refusal
from dock_gateway.sites.tunnel.failures import SiteFailed, SiteTimeout
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway
from tests.support.hub import SmallHub, small_hub
from tests.support.installed import needs
from tests.support.nats import NatsServer, nats_server
from tests.support.waiting import until

pytestmark = [needs("audit_log"), pytest.mark.ros, pytest.mark.asyncio(loop_scope="module")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("site")


@pytest.fixture(scope="module")
def nats(folder: Path) -> Iterator[NatsServer]:
    with nats_server(folder) as server:
        yield server


@pytest.fixture(scope="module")
def signer(folder: Path) -> Signer:
    return Signer.load_or_create(folder / "hub.key")


@pytest.fixture(scope="module")
def site(shared_domain: int, nats: NatsServer, signer: Signer, folder: Path) -> Iterator[RunningGateway]:
    """A site that allows its hub the robot without a namespace, and no more than an operator."""
    (keys := folder / "hub.json").write_bytes(orjson.dumps(signer.public_keys()))
    hub = {"nats": nats.url, "site": "berlin", "hub_public_keys": str(keys), "hub_robots": "/"}
    with running_dock_server(shared_domain), running_gateway(shared_domain, **hub) as gateway:
        gateway.wait_until_ready()
        yield gateway


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def hub(nats: NatsServer, site: RunningGateway, signer: Signer) -> AsyncIterator[SmallHub]:
    async with small_hub(nats.url, signer) as hub:
        await hub.wait_for_site()
        yield hub


def state_of(site: RunningGateway) -> dict[str, Any]:
    state: dict[str, Any] = site.http.get("/healthz").json()["hub"]
    return state


def records(site: RunningGateway) -> dict[str, Any]:
    """The audit log by the goals that it is about."""
    return {each["goal_id"]: each for each in site.http.get("/audit").json()["records"]}


async def test_a_user_of_the_hub_docks(site: RunningGateway, hub: SmallHub) -> None:
    session = (await hub.request("GET", "/session")).json()["principal"]
    assert (session["name"], session["kind"], session["role"]) == ("hub:alice", "hub", "operator")
    sent = await hub.request("POST", "/dock")
    assert sent.status == 202
    goal_id = sent.json()["goal_id"]
    await until(lambda: goal_id in records(site))
    assert (records(site)[goal_id]["principal"], records(site)[goal_id]["role"]) == ("hub:alice", "operator")
    assert (await hub.request("POST", "/stop")).status == 200
    await until(lambda: site.http.get(f"/goals/{goal_id}").json()["status"] == "canceled")
    assert (await hub.request("GET", f"/goals/{goal_id}")).json()["status"] == "canceled"
    assert (await hub.request("DELETE", "/stop")).status == 403
    await asyncio.to_thread(site.http.delete, "/stop")


async def test_a_hub_can_do_no_more_than_the_site_allows(hub: SmallHub) -> None:
    for method, path, grant, code in (
        ("POST", "/dock", Grant(Role.VIEWER), "role_required"),
        ("DELETE", "/stop", UNLIMITED, "role_required"),
        ("GET", "/users", UNLIMITED, "role_required"),
        ("POST", "/dock?robot=/robot1", UNLIMITED, "not_allowed"),
        ("POST", "/dock", Grant(Role.OPERATOR, ("/robot1",)), "not_allowed"),
    ):
        answer = await hub.request(method, path, grant=grant)
        assert (answer.status, answer.json()["code"]) == (403, code), path


async def test_sockets(hub: SmallHub) -> None:
    async with hub.websocket("/ws") as socket:
        await socket.send(orjson.dumps({"op": "release_stop", "id": "1"}).decode())
        await socket.send(orjson.dumps({"op": "stop", "id": "2", "latch": False}).decode())
        answers: dict[str, Any] = {}
        while "2" not in answers:
            said = orjson.loads(await anext(socket))
            answers[said.get("id")] = said
    assert (answers["1"]["error"]["code"], answers["2"]["op"]) == ("role_required", "ack")


@needs("rosbridge")
async def test_rosbridge_through_the_tunnel(hub: SmallHub) -> None:
    async with hub.websocket("/rosbridge") as socket:
        await socket.send(
            '{"op": "call_service", "service": "/rosapi/topics_for_type", "args": {"type": "x"}, "id": "1"}'
        )
        answer = orjson.loads(await anext(socket))
    assert (answer["op"], answer["id"]) == ("service_response", "1")


async def refusal(hub: SmallHub, token: str) -> str:
    with pytest.raises(SiteFailed) as refused:
        await hub.request("POST", "/stop", token=token)
    assert (refused.value.code, refused.value.extra["reason"]) == ("site_refused", "invalid_identity")
    return refused.value.detail.partition("who asks is not accepted: ")[2]


async def test_identities_that_are_refused(site: RunningGateway, hub: SmallHub, tmp_path: Path) -> None:
    address, now = hub.address, hub.clock()
    stranger = Signer.load_or_create(tmp_path / "stranger.key")

    def signed(signer: Signer, name: str = "berlin", instance: str = address.instance, at: float = now) -> str:
        return signer.sign(name, instance, "alice", UNLIMITED, "POST", "/stop", at)

    assert await refusal(hub, signed(stranger)) == "it is not signed with a key of the site's --hub-public-keys"
    assert (
        await refusal(hub, signed(hub.signer, "oslo")) == "it is for another site, or for another process of this one"
    )
    assert await refusal(hub, signed(hub.signer, instance="0" * 16)) == (
        "it is for another site, or for another process of this one"
    )
    assert await refusal(hub, hub.sign("GET", "/stop")) == "it is for another request"
    assert await refusal(hub, hub.sign("POST", "/stop", query="robot=/robot1")) == "it is for another request"
    assert await refusal(hub, signed(hub.signer, at=now - 60)) == "it has expired"
    assert (await hub.request("GET", "/stop")).json()["latched"] is False
    metrics = await asyncio.to_thread(lambda: site.http.get("/metrics").text)
    assert re.search(r'^dock_gateway_hub_refused_total{reason="invalid_identity"} [1-9]', metrics, re.MULTILINE)


async def test_a_request_that_comes_twice_is_carried_out_once(site: RunningGateway, hub: SmallHub) -> None:
    token = hub.sign("POST", "/stop")
    assert (await hub.request("POST", "/stop", token=token)).status == 200
    await asyncio.to_thread(site.http.delete, "/stop")
    with pytest.raises(SiteTimeout, match="whether it has acted is not known"):
        await hub.request("POST", "/stop", token=token, deadline=1.0)
    assert (await hub.request("GET", "/stop")).json()["latched"] is False


async def test_a_clock_that_is_an_hour_off(hub: SmallHub) -> None:
    hub.late = 3600
    assert (await hub.request("GET", "/robots")).status == 200
    with pytest.raises(SiteFailed, match="it has expired"):
        await hub.request("GET", "/robots", corrected=False)
    hub.late = 0


async def test_refused_lost_and_back(nats: NatsServer, site: RunningGateway, hub: SmallHub) -> None:
    hub.refusal = Refusal(code="site_name_taken", detail="the name berlin belongs to another gateway")
    await until(lambda: state_of(site)["state"] == "refused")
    assert state_of(site)["detail"] == hub.refusal.detail
    hub.refusal = None
    nats.kill()
    await until(lambda: state_of(site)["code"] == "broker_unavailable")
    assert site.http.get("/readyz").json()["ready"]  # it works on without its hub
    nats.start()
    await hub.wait_for_site()
    assert (await hub.request("GET", "/session")).json()["principal"]["name"] == "hub:alice"
    assert state_of(site)["state"] == "connected"


async def test_an_exit_is_said_before_streams_end(
    shared_domain: int, nats: NatsServer, signer: Signer, folder: Path
) -> None:
    settings = {"nats": nats.url, "site": "oslo", "hub_public_keys": str(folder / "hub.json"), "authentication": "true"}
    with running_gateway(shared_domain, **settings) as gateway:
        async with small_hub(nats.url, signer, "oslo") as hub:
            await hub.wait_for_site()
            async with hub.websocket("/ws/feedback") as socket:
                messages = aiter(socket)
                await anext(messages)
                gateway.process.send_signal(signal.SIGTERM)
                last = [orjson.loads(message) async for message in messages][-1]
            assert last["type"] == "closing"
            assert hub.hellos[-1].leaving
    assert "Traceback" not in gateway.process.output

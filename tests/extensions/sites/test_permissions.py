"""The configurations of docs/extensions/sites-nats.md, with real NATS servers: sites and hub reach each other only."""

import asyncio
import contextlib
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from starlette.types import Receive, Scope, Send

from dock_gateway.core.errors import Unavailable
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, BrokerOptions, open_broker
from dock_gateway.sites.subscription import SiteMessage
from dock_gateway.sites.tunnel.caller import Caller, TunnelAddress
from dock_gateway.sites.tunnel.server import TunnelServer
from tests.support.certificates import Authority
from tests.support.nats import NatsServer, nats_server
from tests.support.nats_credentials import NatsAccount
from tests.support.processes import free_port
from tests.support.tunnel import accept_all, options_of
from tests.support.waiting import until

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/extensions/sites-nats.md").read_text()
ID = "0123456789abcdef"


def block(title: str, folder: Path, **changes: str) -> str:
    """A configuration of the page, for this machine; `NatsServer` adds where it listens for clients."""
    found = re.search(rf'^```conf title="{re.escape(title)}"\n(.*?)^```', PAGE, re.MULTILINE | re.DOTALL)
    assert found, title
    text = re.sub(r'^listen: ".*"\n', "", found[1], flags=re.MULTILINE).replace("/etc/nats", str(folder))
    for old, new in changes.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    """Has issued the server's certificate."""
    made = Authority(tmp_path)
    made.issue("server")
    assert made.file.exists()
    return made


def as_user(server: NatsServer, authority: Authority, user: str) -> BrokerOptions:
    """How a user of the page connects."""
    return replace(options_of(server.url_of(user, f"change-me-{user}"), user), ca=authority.file)


async def hello(scope: Scope, receive: Receive, send: Send) -> None:
    """An app."""
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"hello of " + scope["path"].encode()})


class Subscriber:
    """Keeps the subjects that it hears."""

    def __init__(self) -> None:
        self.heard: list[str] = []

    async def __call__(self, received: SiteMessage) -> None:
        self.heard.append(received.subject)
        await received.reply(b"{}")


@asynccontextmanager
async def connected(*options: BrokerOptions) -> AsyncIterator[list[Broker]]:
    """Connections to a broker."""
    if not options:
        yield []
        return
    async with open_broker(options[0]) as first, connected(*options[1:]) as others:
        await until(lambda: first.connected)
        yield [first, *others]


async def says_hello(site: Broker, name: str) -> None:
    """Ask until there is an answer: a leaf node, or a cluster, gets to know of subscriptions a little later."""
    for _ in range(1000):
        with contextlib.suppress(Unavailable, TimeoutError):
            assert await site.request(subjects.hello(name), b"{}", 0.5) == b"{}"
            return
        await asyncio.sleep(0.02)


async def works(hub: Broker, site: Broker, name: str) -> None:
    """A hello, and a request through the tunnel, both ways."""
    hellos = Subscriber()
    subscription = await hub.subscribe(subjects.HELLOS, hellos)
    caller, server = Caller(hub), TunnelServer(site, address := TunnelAddress(name, ID), hello, accept_all, {})
    await caller.open()
    await server.open()
    await hub.flush(60)
    await site.flush(60)

    await says_hello(site, name)
    assert set(hellos.heard) == {subjects.hello(name)}
    answer = await caller.request(address, "GET", "/there", token="", deadline=60)
    assert answer.body == b"hello of /there"
    await server.close()
    await caller.close()
    await subscription.close()


async def reaches_nothing_else(hub: Broker, berlin: Broker, oslo: Broker) -> None:
    """A site cannot speak as another, nor read or answer what is for it; nor can the hub speak as a site."""
    at_hub, at_berlin, at_oslo = Subscriber(), Subscriber(), Subscriber()
    for subject in (subjects.HELLOS, subjects.streams_to_hub("berlin"), subjects.streams_to_hub("oslo")):
        await hub.subscribe(subject, at_hub)
    await oslo.subscribe(f"dock.site.oslo.{ID}.>", at_oslo)
    secrets = (
        "dock.site.oslo.>",
        "dock.site.>",
        "dock.hub.>",
        "dock.>",
        ">",
        "_INBOX.>",
        "_INBOX.oslo.>",
        "_INBOX.hub.>",
    )
    for subject in secrets:
        await berlin.subscribe(subject, at_berlin)
    await until(lambda: berlin.refused["not_permitted"] == len(secrets))
    forged = (
        subjects.hello("oslo"), subjects.stream_to_hub("oslo", ID), subjects.open_stream("oslo", ID),
        subjects.stream_to_site("oslo", ID, ID), "_INBOX.hub.1", "_INBOX.oslo.1", "dock.site.berlin.x",
    )  # fmt: skip
    for subject in forged:
        await berlin.publish(subject, b"forged")
    await until(lambda: berlin.refused["not_permitted"] == len(secrets) + len(forged))
    for subject in ("dock.hub.hello.oslo", "_INBOX.oslo.1"):
        await hub.publish(subject, b"forged")
    await hub.subscribe("dock.site.>", at_hub)
    await until(lambda: hub.refused["not_permitted"] == 3)
    assert await oslo.request(subjects.hello("oslo"), b"", 60) == b"{}"
    assert await hub.request(subjects.open_stream("oslo", ID), b"", 60) == b"{}"
    assert (at_hub.heard, at_oslo.heard, at_berlin.heard) == (
        [subjects.hello("oslo")], [subjects.open_stream("oslo", ID)], [],
    )  # fmt: skip


async def test_users_with_passwords(tmp_path: Path, authority: Authority) -> None:
    with nats_server(tmp_path, block("nats.conf", tmp_path), "tls") as server:
        users = [as_user(server, authority, user) for user in ("hub", "berlin", "oslo")]
        async with connected(*users) as (hub, berlin, oslo):
            await works(hub, berlin, "berlin")
            await works(hub, oslo, "oslo")
            await reaches_nothing_else(hub, berlin, oslo)


async def test_credentials(tmp_path: Path) -> None:
    account = NatsAccount()
    with nats_server(tmp_path, account.config) as server:
        commands = re.findall(r"nsc add user (\w+) --allow-pub '(.*?)' --allow-sub '(.*?)' --allow-pub-response", PAGE)
        rights = {user: (publish, subscribe) for user, publish, subscribe in commands}
        rights["oslo"] = tuple(each.replace("berlin", "oslo") for each in rights["berlin"])
        files = {
            user: account.add_user(tmp_path / f"{user}.creds", *(each.split(",") for each in rights[user]))
            for user in rights
        }
        users = [replace(options_of(server.url, user), credentials=files[user]) for user in ("hub", "berlin", "oslo")]
        async with connected(*users) as (hub, berlin, oslo):
            await works(hub, berlin, "berlin")
            await reaches_nothing_else(hub, berlin, oslo)


async def test_a_leaf_node_at_a_site(tmp_path: Path, authority: Authority) -> None:
    """Through its own server, a site can do as much as without it, and no more."""
    way_in = f"127.0.0.1:{free_port()}"
    office = block(
        "nats.conf", tmp_path, **{'"dock.hub.stream.berlin.*"': '"dock.hub.stream.berlin.*", "_INBOX.hub.>"'}
    )
    office += block("office.conf", tmp_path, **{"0.0.0.0:7422": way_in})
    leaf = block("leaf.conf", tmp_path, **{"nats.example.com:7422": way_in})
    with nats_server(tmp_path, office, "tls") as server, nats_server(tmp_path, leaf) as own:
        users = [as_user(server, authority, "hub"), options_of(own.url, "berlin"), as_user(server, authority, "oslo")]
        async with connected(*users) as (hub, berlin, oslo):
            await works(hub, berlin, "berlin")
            await works(hub, oslo, "oslo")
            await at_a_leaf_reaches_nothing_else(hub, berlin, oslo)


async def at_a_leaf_reaches_nothing_else(hub: Broker, berlin: Broker, oslo: Broker) -> None:
    """The site's own server lets it do anything, but passes nothing on that its user may not."""
    at_hub, at_berlin, at_oslo = Subscriber(), Subscriber(), Subscriber()
    for subject in (subjects.HELLOS, subjects.streams_to_hub("berlin"), subjects.streams_to_hub("oslo")):
        await hub.subscribe(subject, at_hub)
    await oslo.subscribe(f"dock.site.oslo.{ID}.>", at_oslo)
    await says_hello(berlin, "berlin")
    at_hub.heard.clear()
    for subject in ("dock.site.oslo.>", "dock.hub.>", "_INBOX.oslo.>", "_INBOX.hub.>"):
        await berlin.subscribe(subject, at_berlin)
    forged = subjects.hello("oslo"), subjects.open_stream("oslo", ID), subjects.stream_to_hub("oslo", ID)
    for subject in forged:
        await berlin.publish(subject, b"forged")
    await berlin.publish(subjects.hello("berlin"), b"")
    await until(lambda: len(at_hub.heard) > 0)  # whatever was published before it has come, too
    assert await oslo.request(subjects.hello("oslo"), b"", 60) == b"{}"
    assert await hub.request(subjects.open_stream("oslo", ID), b"", 60) == b"{}"
    await berlin.flush(60)
    assert set(at_hub.heard) == {subjects.hello("berlin"), subjects.hello("oslo")}
    assert at_oslo.heard == [subjects.open_stream("oslo", ID)]
    assert sorted(at_berlin.heard) == sorted([*forged, subjects.hello("berlin")])  # its own, of its own server


async def test_a_cluster(tmp_path: Path, authority: Authority) -> None:
    """The hub at one server, the site at the other; a site that loses its server takes the other one."""
    routes = [f"127.0.0.1:{free_port()}" for _ in range(2)]
    servers = []
    for own in routes:
        changes = {"0.0.0.0:6222": own, "nats1.example.com:6222": routes[0], "nats2.example.com:6222": routes[1]}
        servers.append(block("nats.conf", tmp_path) + block("cluster.conf", tmp_path, **changes))
    with nats_server(tmp_path, servers[0], "tls") as one, nats_server(tmp_path, servers[1], "tls") as other:
        site = as_user(one, authority, "berlin")
        site = replace(site, urls=(*site.urls, *as_user(other, authority, "berlin").urls))
        async with connected(as_user(other, authority, "hub"), site) as (hub, berlin):
            await works(hub, berlin, "berlin")
            one.kill()
            await works(hub, berlin, "berlin")

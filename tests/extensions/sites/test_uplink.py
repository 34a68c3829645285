"""A site and its hub agree on a key, over a real NATS server; again when either is another process."""

# ruff: noqa: SLF001 - the tunnel of another process, and what one sends, are private

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import orjson
import pytest

from dock_gateway import __version__
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.extensions.sites.uplink import Uplink
from dock_gateway.observability.schema import HubState
from dock_gateway.sites import subjects
from dock_gateway.sites.identity import AGREEMENT, Signer
from dock_gateway.sites.messages import Welcome
from dock_gateway.sites.seals import KeyAgreement
from dock_gateway.sites.subscription import SiteMessage
from dock_hub.site_client import READER
from dock_hub.sites import Sites
from tests.support.history import HistoryInMemory
from tests.support.nats import NatsServer, nats_server
from tests.support.open_hub import Hub, hub_at
from tests.support.small_site import APP, broker_of
from tests.support.waiting import until


@asynccontextmanager
async def site_at(server: NatsServer, folder: Path, history: HistoryInMemory) -> AsyncIterator[Uplink]:
    """One process of the site berlin."""
    keys = folder / "hub.json"
    keys.write_bytes(orjson.dumps(Signer.load_or_create(folder / "hub.key").public_keys()))
    settings = SiteSettings(nats=(server.url,), site="berlin", hub_public_keys=keys)
    uplink = Uplink(settings, history, HubLink("berlin"))  # type: ignore[arg-type]
    await uplink.open(APP, {})
    try:
        yield uplink
    finally:
        await uplink.leave()
        await uplink.close()


async def agreed(hub: Hub, site: Uplink) -> bytes:
    """Wait until both have the same key, and nothing that the hub sends waits with what others send."""
    caller = hub.parts[Sites]._caller
    await until(lambda: site._tunnel is not None and site._tunnel.key == caller.keys.get(site._address, 0))
    await hub.connected("berlin")
    assert site._tunnel is not None
    unsealed = site._tunnel._unsealed
    site._tunnel._unsealed = None  # what has no seal is dropped
    await hub.parts[Sites].client("berlin").measure()
    site._tunnel._unsealed = unsealed
    assert site._tunnel.key is not None
    return site._tunnel.key


async def test_a_hub_and_a_site_agree_whichever_of_them_is_another_process(tmp_path: Path) -> None:
    history = HistoryInMemory()
    with nats_server(tmp_path) as server:
        async with site_at(server, tmp_path, history) as site:
            async with hub_at(server.url, tmp_path) as hub:
                first = await agreed(hub, site)
            async with hub_at(server.url, tmp_path) as hub:
                second = await agreed(hub, site)
        async with hub_at(server.url, tmp_path) as hub, site_at(server, tmp_path, history) as site:
            third = await agreed(hub, site)
            caller = hub.parts[Sites]._caller
            assert len(caller.keys) == 1
            await hub.parts[Sites].forget("berlin")
            assert caller.keys == {}
    assert len({first, second, third}) == 3


@pytest.mark.parametrize("proof", ["", "x.y.z", "another", "stranger"])
async def test_only_the_hub_agrees_with_a_site(proof: str, tmp_path: Path) -> None:
    """Who answers hellos in place of the hub gets no key. The site serves the hub all the same."""
    signers = {name: Signer.load_or_create(tmp_path / f"{name}.key") for name in ("hub", "stranger")}
    keys, heard = KeyAgreement(), []

    async def answer(received: SiteMessage) -> None:
        hello = orjson.loads(received.data)
        heard.append(hello)
        about = {"another": (signers["hub"], "another site's key"), "stranger": (signers["stranger"], hello["public"])}
        said = proof
        if proof in about:
            signer, public = about[proof]
            said = signer.sign(
                "berlin", hello["instance"], None, READER, AGREEMENT, keys.public, time.time(), content=public
            )
        welcome = Welcome(hub_version=__version__, at=time.time(), public=keys.public, proof=said)
        await received.reply(welcome.encode())

    with nats_server(tmp_path) as server:
        async with broker_of(server.url, "hub") as broker:
            await broker.subscribe(subjects.HELLOS, answer)
            async with site_at(server, tmp_path, HistoryInMemory()) as site:
                await until(lambda: len(heard) > 0 and site._link.state is HubState.CONNECTED)
                await asyncio.sleep(0)
                assert site._tunnel is not None
                assert site._tunnel.key is None
                assert {hello["agreed"] for hello in heard} == {""}

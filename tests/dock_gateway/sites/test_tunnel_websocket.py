"""WebSockets through the tunnel, over a real NATS server."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.responses import JSONResponse
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from dock_gateway.core.errors import GatewayError
from dock_gateway.sites import subjects
from dock_gateway.sites.tunnel.channel import Timing
from dock_gateway.sites.tunnel.conversation import Conversation
from dock_gateway.sites.tunnel.failures import SiteFailed, SiteTimeout, SiteUnreachable
from dock_gateway.sites.tunnel.frames import WINDOW, encode
from tests.support.nats import NatsServer, nats_server
from tests.support.proxy import Proxy
from tests.support.tunnel import SITE, Client, Tunnel, open_tunnel
from tests.support.waiting import until


class Site:
    """A small app, and what happens in it."""

    def __init__(self) -> None:
        self.written = 0
        self.closed: list[tuple[int, str]] = []
        routes = [
            WebSocketRoute("/echo", self.echo),
            WebSocketRoute("/endless", self.endless),
            WebSocketRoute("/refused", self.refused),
            WebSocketRoute("/denied", self.denied),
            WebSocketRoute("/closes", self.closes),
        ]
        self.app = Starlette(routes=routes)

    async def echo(self, websocket: WebSocket) -> None:
        """Say what has come, until the client goes."""
        await websocket.accept("two" if "two" in websocket.scope["subprotocols"] else None)
        try:
            while True:
                message = await websocket.receive()
                if message["type"] == "websocket.disconnect":
                    self.closed.append((message["code"], message["reason"]))
                    return
                text = message.get("text")
                await (websocket.send_bytes(message["bytes"]) if text is None else websocket.send_text(text))
        except WebSocketDisconnect as gone:
            self.closed.append((gone.code, gone.reason))

    async def endless(self, websocket: WebSocket) -> None:
        """Send, until the client goes."""
        await websocket.accept()
        try:
            while True:
                await websocket.send_text("x" * 10_000)
                self.written += 10_000
        except WebSocketDisconnect as gone:
            self.closed.append((gone.code, gone.reason))

    async def refused(self, websocket: WebSocket) -> None:
        problem = {"code": "role_required", "detail": "not you", "status": 403}
        await websocket.send_denial_response(JSONResponse(problem, 403, {"Retry-After": "1"}))

    async def denied(self, websocket: WebSocket) -> None:
        await websocket.close()

    async def closes(self, websocket: WebSocket) -> None:
        await websocket.accept()
        await websocket.send_text("last")
        await websocket.close(4401, "invalid_token")


@pytest.fixture
def server(tmp_path: Path) -> Iterator[NatsServer]:
    with nats_server(tmp_path) as running:
        yield running


async def test_messages_both_ways(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        client = Client("websocket", subprotocols=["one", "two"])
        forwarding = client.forward(tunnel, "/echo")
        messages: list[str | bytes] = ["hi", b"\x00\xff", "", b"", "ü" * 200_000, b"x" * 2_000_000, "last"]
        for message in messages:
            client.put({"type": "websocket.receive", "text" if isinstance(message, str) else "bytes": message})
        await until(lambda: len(client.sent) == len(messages) + 1)
        assert client.sent[0] == {"type": "websocket.accept", "subprotocol": "two", "headers": []}
        assert [each.get("text", each.get("bytes")) for each in client.sent[1:]] == messages
        client.put({"type": "websocket.disconnect", "code": 4001, "reason": "enough"})
        await forwarding
        await until(lambda: site.closed == [(4001, "enough")])
        await until(lambda: tunnel.server.calls == 0)


async def test_the_site_closes(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        client = Client("websocket")
        await client.forward(tunnel, "/closes")
        closed = {"type": "websocket.close", "code": 4401, "reason": "invalid_token"}
        assert client.sent[1:] == [{"type": "websocket.send", "text": "last"}, closed]
        async with tunnel.caller.websocket(tunnel.address, "/closes", token="") as conversation:
            assert [message async for message in conversation] == ["last"]
            assert (conversation.close_code, conversation.close_reason) == (4401, "invalid_token")
            assert [message async for message in conversation] == []
            with pytest.raises(SiteUnreachable):
                await conversation.send("too late")


async def test_a_refused_handshake_has_its_status(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        client = Client("websocket")
        await client.forward(tunnel, "/refused")
        assert (client.status, client.complete, client.answer_headers["retry-after"]) == (403, True, "1")
        assert b"not you" in client.answer
        client = Client("websocket")
        await client.forward(tunnel, "/denied")
        assert (client.status, client.complete) == (403, True)
        client = Client("websocket")
        await client.forward(tunnel, "/none")
        assert client.status in {403, 404}
        client = Client("websocket", denials=False)
        await client.forward(tunnel, "/refused")
        assert [message["type"] for message in client.sent] == ["websocket.close"]
        for path, code in (("/refused", "role_required"), ("/denied", "site_failed")):
            with pytest.raises(GatewayError) as refused:
                async with tunnel.caller.websocket(tunnel.address, path, token=""):
                    pass
            assert refused.value.code == code


async def test_who_does_not_read(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        client = Client("websocket")
        client.reads.clear()
        forwarding = client.forward(tunnel, "/endless")
        await until(lambda: site.written > WINDOW // 2)
        async with tunnel.caller.websocket(tunnel.address, "/echo", token="") as conversation:
            for _ in range(10):
                await conversation.send("x" * 100_000)
                assert len(await anext(conversation)) == 100_000
        assert site.written <= WINDOW
        client.reads.set()
        await until(lambda: len(client.sent) > 200)
        client.put({"type": "websocket.disconnect", "code": 1001})
        await forwarding
        await until(lambda: tunnel.server.calls == 0)


async def test_a_conversation_that_is_left_is_closed(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        async with tunnel.caller.websocket(tunnel.address, "/echo", token="", query="a=1") as conversation:
            await conversation.send("one")
            assert await anext(conversation) == "one"
        await until(lambda: site.closed == [(1000, "")])
        with pytest.raises(ValueError, match="mine"):
            async with tunnel.caller.websocket(tunnel.address, "/echo", token=""):
                raise ValueError("mine")
        await until(lambda: site.closed[1:] == [(1006, "client_gone")])
        assert tunnel.caller.streams == 0


async def read_all(conversation: Conversation) -> None:
    async for _ in conversation:
        pass


async def wait_open(client: Client) -> None:
    await until(lambda: bool(client.sent))


@pytest.mark.parametrize("who", ["broker", "hub", "site"])
async def test_a_connection_that_is_cut(server: NatsServer, who: str) -> None:
    """Whoever loses the broker: the stream ends at both ends, and afterwards all is as before."""
    site = Site()
    proxy = Proxy([("127.0.0.1", server.port)])
    cut = proxy.url.replace("http", "nats")
    timing = Timing(alive=0.1, silence=1.5)
    hub_url, site_url = (cut if who == "hub" else server.url), (cut if who == "site" else server.url)
    async with open_tunnel(hub_url, site.app, timing=timing, site_url=site_url) as tunnel:
        client = Client("websocket")
        forwarding = client.forward(tunnel, "/echo")
        async with tunnel.caller.websocket(tunnel.address, "/echo", token="") as conversation:
            await wait_open(client)
            if who == "broker":
                server.kill()
                server.start()
            else:
                proxy.cut()
            with pytest.raises(SiteUnreachable):
                await anext(conversation)
        await forwarding
        assert client.sent[-1]["type"] == "websocket.close"
        assert client.sent[-1]["code"] == 1014
        await until(lambda: tunnel.server.calls == 0 and len(site.closed) == 2)
        await until(lambda: tunnel.hub.connected and tunnel.site.connected)
        await echoes(tunnel)
    proxy.close()


async def echoes(tunnel: Tunnel) -> None:
    async with tunnel.caller.websocket(tunnel.address, "/echo", token="") as conversation:
        await conversation.send("again")
        assert await anext(conversation) == "again"


async def test_who_says_nothing_any_more_is_given_up(server: NatsServer) -> None:
    """A stream without signs of life ends at either end; one with them goes on."""
    site = Site()
    timing = Timing(alive=0.05, silence=1.5)
    async with open_tunnel(server.url, site.app, timing=timing) as tunnel:
        async with tunnel.caller.websocket(tunnel.address, "/echo", token="") as conversation:
            beats = next(iter(tunnel.caller._channels.values()))
            await until(lambda: beats._received > 10)
            await conversation.send("still there")
            assert await anext(conversation) == "still there"
            for subscription in tunnel.server._subscriptions:
                await subscription.close()  # the site hears nothing more, and says so
            await until(lambda: tunnel.server.calls == 0)
            with pytest.raises(SiteUnreachable, match="nothing was heard"):
                await anext(conversation)
        with pytest.raises(SiteUnreachable):
            await echoes(tunnel)


async def test_a_handshake_without_an_answer(server: NatsServer) -> None:
    async def silent(scope: object, receive: object, send: object) -> None:
        await asyncio.Event().wait()

    async with open_tunnel(server.url, silent) as tunnel:  # type: ignore[arg-type]
        with pytest.raises(SiteTimeout):
            async with tunnel.caller.websocket(tunnel.address, "/", token="", deadline=0.1):
                pass
        client = Client("websocket")
        with pytest.raises(SiteTimeout):
            await client.forward(tunnel, "/", deadline=0.1)
        assert client.sent == []


async def test_messages_that_are_not_valid_end_the_stream(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        for frames in (
            [encode({"type": "text", "n": 2, "more": False}, b"\xff")],
            [encode({"type": "text", "n": 2, "more": True}, b"x"), encode({"type": "bytes", "n": 3}, b"x")],
            [encode({"type": "head", "n": 2, "status": 200})],
            [encode({"type": "text", "n": number}, b"x" * 120_000) for number in range(2, 20)],
        ):
            async with tunnel.caller.websocket(tunnel.address, "/echo", token="") as conversation:
                key = next(iter(tunnel.caller._channels))
                for frame in frames:
                    await tunnel.site.publish(subjects.stream_to_hub(SITE, key[1]), frame)
                await tunnel.site.flush(60)
                with pytest.raises((SiteUnreachable, SiteFailed)):
                    await read_all(conversation)
            tunnel.hub.refused.clear()
        await until(lambda: tunnel.server.calls == 0)
        assert {reason for _, reason in site.closed} == {"malformed", "too_much"}

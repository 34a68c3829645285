"""HTTP requests through the tunnel, over a real NATS server."""

import asyncio
import json
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route

from dock_gateway.core.errors import GatewayError, NotAllowed, NotAuthenticated, TooManyRequests
from dock_gateway.sites import subjects
from dock_gateway.sites.identity import IdentityReused
from dock_gateway.sites.seals import seal
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.sites.tunnel.failures import SiteFailed, SiteTimeout, SiteUnreachable
from dock_gateway.sites.tunnel.frames import WINDOW, encode
from tests.support.nats import NatsServer, nats_server
from tests.support.tunnel import SITE, Client, open_tunnel
from tests.support.waiting import until


class Site:
    """A small app, and what happens in it."""

    def __init__(self) -> None:
        self.written = 0
        self.go_on = asyncio.Event()
        self.running = 0
        routes = [
            Route("/echo", self.echo, methods=["GET", "POST"]),
            Route("/endless", self.endless),
            Route("/wait", self.wait, methods=["GET", "POST"]),
            Route("/unread", self.unread, methods=["POST"]),
            Route("/broken", self.broken),
            Route("/half", self.half),
            Route("/big", self.big),
            Route("/lies/{status:int}", self.lies),
        ]
        self.app = Starlette(routes=routes)

    async def echo(self, request: Request) -> Response:
        """Answer with the request."""
        body = await request.body()
        about = {
            "method": request.method, "query": request.url.query, "size": len(body), "sum": sum(body) % 65521,
            "headers": dict(request.headers), "client": request.client and request.client.host,
            "hub": request.scope["forwarded"], "state": request.state.settings,
        }  # fmt: skip
        headers = {"X-Request-Id": "7", "Set-Cookie": "a=b", "Content-Security-Policy": "none", "Server": "x"}
        return JSONResponse(about, 201, headers)

    async def endless(self, _: Request) -> Response:
        """Stream, until the client goes."""

        async def pieces() -> AsyncIterator[bytes]:
            while True:
                yield b"x" * 50_000
                self.written += 50_000

        return StreamingResponse(pieces())

    async def wait(self, request: Request) -> Response:
        """Wait until the test, or the client, has had enough."""
        self.running += 1
        going = [asyncio.create_task(self.go_on.wait()), asyncio.create_task(self._disconnected(request))]
        try:
            await asyncio.wait(going, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self.running -= 1
            for each in going:
                each.cancel()
        return PlainTextResponse("done")

    async def _disconnected(self, request: Request) -> None:
        while (await request.receive())["type"] != "http.disconnect":
            pass

    async def unread(self, _: Request) -> Response:
        """Answer without reading the body."""
        return PlainTextResponse("not interested", 400)

    async def broken(self, _: Request) -> Response:
        raise ValueError("a bug")

    async def half(self, _: Request) -> Response:
        """Fail within the answer."""

        async def pieces() -> AsyncIterator[bytes]:
            yield b"half"
            raise ValueError("a bug")

        return StreamingResponse(pieces())

    async def lies(self, request: Request) -> Response:
        """Answer with what a hub must not pass on."""
        headers = {"Location": "https://evil.example", "Content-Type": "text/javascript", "Content-Length": "2"}
        return StreamingResponse(iter([b"longer"]), request.path_params["status"], headers)

    async def big(self, _: Request) -> Response:
        return PlainTextResponse(b"0123456789" * 500_000)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[NatsServer]:
    with nats_server(tmp_path) as running:
        yield running


async def test_a_request_is_one_of_the_sites_app(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        headers = [
            (b"Accept", b"text/plain"), (b"Cookie", b"session=1"), (b"Authorization", b"Bearer x"), (b"Host", b"hub"),
            (b"Origin", b"https://hub"), (b"X-Forwarded-For", b"1.2.3.4"), (b"Idempotency-Key", b"\xfc"),
        ]  # fmt: skip
        client = Client(query=b"a=%20b", headers=headers)
        client.body(b"")
        await client.forward(tunnel, "/echo", token="who")
        about = json.loads(client.answer)
        assert (client.status, client.complete, about["method"], about["query"]) == (201, True, "GET", "a=%20b")
        assert about["headers"] == {"host": "localhost", "accept": "text/plain", "idempotency-key": "ü"}
        assert (about["client"], about["state"]) == ("192.0.2.7", "of the site")
        assert about["hub"] == {"token": "who", "method": "GET", "path": "/echo"}
        # The page is the hub's: a site sets no cookies there, and its answers run no scripts.
        assert client.answer_headers == {
            "content-type": "application/json", "x-request-id": "7",
            "content-security-policy": "sandbox; default-src 'none'", "x-content-type-options": "nosniff",
        }  # fmt: skip
        assert tunnel.caller.streams == 0
        await until(lambda: tunnel.server.streams == 0)


@pytest.mark.parametrize("pieces", [[b"x" * 3_000_000], [b"ab" * 70_000] * 30, [b"", b"", b"end"], [b"x"]])
async def test_bodies_arrive_whole(server: NatsServer, pieces: list[bytes]) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        client = Client(method="POST")
        client.body(*pieces)
        await client.forward(tunnel, "/echo")
        body = b"".join(pieces)
        about = json.loads(client.answer)
        assert (about["size"], about["sum"]) == (len(body), sum(body) % 65521)


async def test_large_answers_and_the_hubs_own_requests(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        answer = await tunnel.caller.request(tunnel.address, "GET", "/big", token="", deadline=60)
        assert (answer.status, answer.body) == (200, b"0123456789" * 500_000)
        body = b"x" * 1_000_000
        answer = await tunnel.caller.request(
            tunnel.address, "POST", "/echo", token="", deadline=60, query="a=1", headers=[(b"a", b"b")], body=body
        )
        assert (answer.status, answer.json()["size"], answer.json()["headers"]["a"]) == (201, 1_000_000, "b")
        assert answer.json()["query"] == "a=1"
        assert (await tunnel.caller.request(tunnel.address, "GET", "/none", token="", deadline=60)).status == 404
        with pytest.raises(SiteTimeout, match=r"0\.05 s; whether it has acted is not known"):
            await tunnel.caller.request(tunnel.address, "GET", "/wait", token="", deadline=0.05)


async def test_who_does_not_read_holds_up_nobody_else(server: NatsServer) -> None:
    """What waits for a client is bounded at both ends, and other streams go on."""
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        client = Client()
        client.body(b"")
        client.reads.clear()
        forwarding = client.forward(tunnel, "/endless")
        await until(lambda: site.written > WINDOW // 2)
        for _ in range(5):  # what is written no more does not grow
            await tunnel.caller.request(tunnel.address, "GET", "/big", token="", deadline=60)
        assert site.written <= WINDOW
        client.reads.set()
        await until(lambda: len(client.answer) > 3 * WINDOW)
        client.put({"type": "http.disconnect"})
        await forwarding
        await until(lambda: tunnel.server.calls == 0)


async def test_a_client_that_goes_ends_its_request(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        for method in ("GET", "POST"):
            client = Client(method=method)
            client.put({"type": "http.request", "body": b"1", "more_body": method == "POST"})
            forwarding = client.forward(tunnel, "/wait")
            await until(lambda: site.running == 1)
            client.put({"type": "http.disconnect"})
            await forwarding
            await until(lambda: site.running == tunnel.server.calls == 0)
            assert client.sent == []
        cancelled = Client()
        cancelled.body(b"")
        forwarding = cancelled.forward(tunnel, "/wait")
        await until(lambda: site.running == 1)
        forwarding.cancel()
        await until(lambda: site.running == tunnel.server.calls == 0)


async def test_an_answer_before_the_end_of_the_body(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        client = Client(method="POST")
        client.body(*[b"x" * 1_000_000] * 5)
        await client.forward(tunnel, "/unread")
        assert (client.status, client.answer) == (400, b"not interested")
        assert tunnel.caller.streams == 0


async def test_failures_of_the_app(server: NatsServer, caplog: pytest.LogCaptureFixture) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        assert (await tunnel.caller.request(tunnel.address, "GET", "/broken", token="", deadline=60)).status == 500
        with pytest.raises(SiteFailed):
            await tunnel.caller.request(tunnel.address, "GET", "/half", token="", deadline=60)
    assert caplog.text.count("ValueError: a bug") == 2

    async def silent(*_: Any) -> None:
        pass

    async def raises(*_: Any) -> None:
        raise ValueError("a bug")

    async with open_tunnel(server.url, silent) as tunnel:
        with pytest.raises(SiteFailed, match="has not completed its answer"):
            await tunnel.caller.request(tunnel.address, "GET", "/", token="", deadline=60)
    async with open_tunnel(server.url, raises) as tunnel:
        answer = await tunnel.caller.request(tunnel.address, "GET", "/", token="", deadline=60)
        assert (answer.status, answer.json()["code"]) == (500, "internal_error")


async def test_an_answer_that_leads_elsewhere_or_is_longer_than_it_says(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        for status, body in ((302, b"longer"), (204, b""), (304, b"")):
            client = Client()
            client.body(b"")
            await client.forward(tunnel, f"/lies/{status}")
            assert (client.status, client.answer, client.complete) == (status, body, True)
            assert client.answer_headers.keys() == {"content-security-policy", "x-content-type-options"}


async def test_refusals(server: NatsServer) -> None:
    """A site refuses who it does not know; a request that the network delivers twice is carried out once."""
    errors: dict[str, GatewayError] = {
        "role": NotAllowed("not you", code="role_required"),
        "forged": NotAuthenticated("who asks is not accepted", code="invalid_identity"),
        "twice": IdentityReused("once is enough"),
    }

    def admit(token: str, *_: str) -> Any:
        if token in errors:
            raise errors[token]
        return None

    async with open_tunnel(server.url, Site().app, admit=admit, max_streams=1) as tunnel:

        async def refusal(token: str, deadline: float = 60) -> GatewayError:
            client = Client()
            client.body(b"")
            with pytest.raises(GatewayError) as refused:
                await client.forward(tunnel, "/echo", token=token, deadline=deadline)
            assert client.sent == []
            return refused.value

        role, forged = await refusal("role"), await refusal("forged")
        assert (role.status, role.code, role.detail) == (403, "role_required", "not you")
        assert (forged.status, forged.code, forged.extra["reason"]) == (502, "site_refused", "invalid_identity")
        assert isinstance(await refusal("twice", 0.2), SiteTimeout)
        waiting = Client()
        waiting.body(b"")
        forwarding = waiting.forward(tunnel, "/wait")
        await until(lambda: tunnel.server.streams == 1)
        full = await refusal("")
        assert (full.status, full.code) == (429, "too_many_streams")
        counted = {"role_required": 1, "invalid_identity": 1, "identity_reused": 1, "too_many_streams": 1}
        assert tunnel.site.refused.items() >= counted.items()
        stop = await tunnel.caller.request(tunnel.address, "POST", "/stop", token="", deadline=60)
        assert stop.status == 404
        forwarding.cancel()


async def test_a_flood_that_the_hub_has_not_sealed_leaves_time_for_others(server: NatsServer) -> None:
    """Whatever waits, a request of the hub is next; the others are opened one by one, the newest first."""
    seen: list[str] = []

    def admit(token: str, *_: str) -> Any:
        seen.append(token)
        if token != "token":
            time.sleep(0.002)  # as long as some signatures
            raise NotAuthenticated("who asks is not accepted", code="invalid_identity")

    async with open_tunnel(server.url, Site().app, admit=admit) as tunnel:
        key = tunnel.server.key = tunnel.caller.keys[tunnel.address] = bytes(32)
        subject = subjects.open_stream(SITE, tunnel.address.instance)
        client = Client()
        client.body(b"")
        for number in range(3_000):
            fields = {"id": f"{number:016x}", "token": str(number), "kind": "http", "method": "POST", "path": "/stop"}
            message = encode(fields)
            forgeries = (message, seal(b"another", message), b"x" * 64 + message, seal(key, message)[:-1])
            await tunnel.hub.publish(subject, forgeries[number % 4])
        await client.forward(tunnel, "/echo")
        assert client.status == 201
        assert seen.index("token") < 300
        await until(lambda: tunnel.site.refused["too_many_unsealed"] > 0)
        await until(lambda: "2997" in seen)  # 2999 is cut off, and 2998 is no message


async def test_whatever_opening_one_message_brings_about_the_next_is_opened(
    server: NatsServer, caplog: pytest.LogCaptureFixture
) -> None:
    def admit(token: str, *_: str) -> Any:
        if token == "odd":
            raise ZeroDivisionError("that was not expected")

    async with open_tunnel(server.url, Site().app, admit=admit) as tunnel:
        fields = {"id": f"{1:016x}", "token": "odd", "kind": "http", "method": "GET", "path": "/echo"}
        await tunnel.hub.publish(subjects.open_stream(SITE, tunnel.address.instance), encode(fields))
        await until(lambda: "that was not expected" in caplog.text)
        answer = await tunnel.caller.request(tunnel.address, "GET", "/echo", token="", deadline=10)
        assert answer.status == 201


async def test_a_sealed_request_that_is_repeated_is_refused_before_its_signature(server: NatsServer) -> None:
    admitted: list[str] = []

    def admit(token: str, *_: str) -> Any:
        admitted.append(token)

    async with open_tunnel(server.url, Site().app, admit=admit) as tunnel:
        key = tunnel.server.key = tunnel.caller.keys[tunnel.address] = bytes(32)
        fields = {"id": f"{1:016x}", "token": "token", "kind": "http", "method": "GET", "path": "/echo"}
        for _ in range(500):
            await tunnel.hub.publish(subjects.open_stream(SITE, tunnel.address.instance), seal(key, encode(fields)))
        await until(lambda: tunnel.site.refused["duplicate"] == 499)
        assert admitted == ["token"]


async def test_the_hub_has_a_limit_of_streams(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        tunnel.caller._max_streams = (10, 1)
        client = Client()
        client.body(b"")
        forwarding = client.forward(tunnel, "/wait")
        await until(lambda: tunnel.server.streams == 1)
        another, stop = Client(), Client(method="POST")
        for each in (another, stop):
            each.body(b"")
        with pytest.raises(TooManyRequests):
            await another.forward(tunnel, "/echo")
        await stop.forward(tunnel, "/stop")
        assert stop.status == 404
        assert (await tunnel.caller.request(tunnel.address, "GET", "/echo", token="", deadline=60)).status == 201
        other = TunnelAddress("oslo", tunnel.address.instance)
        with pytest.raises(SiteUnreachable, match="is not connected"):
            await tunnel.caller.request(other, "GET", "/echo", token="", deadline=60)
        forwarding.cancel()


async def test_a_site_that_is_not_there_or_goes(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        last = Client()
        last.body(b"")
        ending = last.forward(tunnel, "/wait")
        await until(lambda: site.running == 1)
        await tunnel.server.close()
        with pytest.raises(SiteFailed, match="shutting down"):
            await ending
        await until(lambda: site.running == 0)
        with pytest.raises(SiteUnreachable):
            await tunnel.caller.request(tunnel.address, "GET", "/echo", token="", deadline=60)


async def test_a_site_that_listens_a_moment_later_gets_the_request(server: NatsServer) -> None:
    async with open_tunnel(server.url, Site().app) as tunnel:
        tunnel.caller._patience = 60
        await tunnel.server.close()
        await tunnel.site.flush(60)  # the broker knows that
        asking = asyncio.create_task(tunnel.caller.request(tunnel.address, "GET", "/echo", token="", deadline=60))
        await until(lambda: tunnel.caller.streams == 1)
        await tunnel.server.open()
        assert (await asking).status == 201


async def test_what_is_no_message_harms_nothing(server: NatsServer) -> None:
    """Nonsense on all subjects is dropped and counted; streams and subscriptions go on."""
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        client = Client()
        client.body(b"")
        forwarding = client.forward(tunnel, "/wait")
        await until(lambda: site.running == 1)
        stream = next(iter(tunnel.server._channels))
        head = {"type": "head", "n": 1, "status": 200}
        nonsense = [
            b"", b"\n", b"{", b"[]\n", b"\xff\xfe\n", b"[" * 1000, b"x" * 600_000, encode({"type": "data"}),
            encode({"type": "data", "n": 0}), encode({"type": "data", "n": "x"}), encode({"type": "what", "n": 1}),
            encode({"type": "data", "n": 1}, b"x" * 200_000), encode({"type": "credit", "n": 1, "bytes": -1}),
            encode(head | {"status": 99}), encode(head | {"headers": [["a\r\nb", "c"]]}),
            encode(head | {"headers": [["a", "b\r\nc: d"]]}),
        ]  # fmt: skip
        to_site = subjects.stream_to_site(SITE, tunnel.address.instance, stream)
        for data in nonsense:
            await tunnel.site.publish(subjects.stream_to_hub(SITE, stream), data)
            await tunnel.hub.publish(to_site, data)
            await tunnel.hub.publish(subjects.open_stream(SITE, tunnel.address.instance), data)
        await tunnel.site.publish(f"dock.hub.stream.{SITE}.1", b"")
        await tunnel.site.publish(subjects.stream_to_hub(SITE, subjects.new_id()), b"")
        await tunnel.hub.publish(subjects.stream_to_site(SITE, tunnel.address.instance, subjects.new_id()), b"")
        await until(lambda: tunnel.hub.refused.total() >= len(nonsense) + 2)
        await until(lambda: tunnel.site.refused.total() >= 2 * len(nonsense) + 1)
        assert set(tunnel.hub.refused) | set(tunnel.site.refused) == {"malformed", "too_large", "unknown_stream"}
        site.go_on.set()
        await forwarding
        assert client.answer == b"done"


async def test_duplicates_and_gaps(server: NatsServer) -> None:
    site = Site()
    async with open_tunnel(server.url, site.app) as tunnel:
        client = Client()
        client.body(b"")
        forwarding = client.forward(tunnel, "/wait")
        await until(lambda: site.running == 1)
        stream = next(iter(tunnel.server._channels))
        to_hub = subjects.stream_to_hub(SITE, stream)
        head = encode({"type": "head", "n": 1, "status": 203, "headers": []})
        for data in (head, head, encode({"type": "data", "n": 2}, b"once"), encode({"type": "data", "n": 2}, b"twice")):
            await tunnel.site.publish(to_hub, data)
        await until(lambda: tunnel.hub.refused["duplicate"] == 2)
        await until(lambda: client.answer == b"once")
        await tunnel.site.publish(to_hub, encode({"type": "data", "n": 4}, b"later"))
        await forwarding
        assert (client.status, client.answer, client.complete) == (203, b"once", False)
        assert tunnel.hub.refused["gap"] == 1
        await until(lambda: site.running == 0)  # the site has heard of it

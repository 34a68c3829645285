"""A site: a gateway that serves a hub through the tunnel, with a small application of its own."""

from urllib.parse import parse_qs

from starlette.types import Receive, Scope, Send

from dock_gateway.core.filters import GoalFilter, WithoutFeedback
from dock_gateway.core.goal import encode
from dock_gateway.sites.broker import Broker, BrokerOptions
from dock_gateway.sites.subjects import inbox, new_id
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.sites.tunnel.server import TunnelServer
from dock_gateway.streams import feed
from tests.dock_gateway.simulation.gateway import Gateway

SITE = "berlin"


def options_of(name: str) -> BrokerOptions:
    """How a process connects to the broker."""
    return BrokerOptions(("nats://simulated",), None, None, name, inbox(name))


class Site(Gateway):
    """One life of the gateway of a site."""

    address: TunnelAddress | None = None

    async def start(self) -> None:
        await super().start()
        self.address = TunnelAddress(SITE, new_id())
        broker = Broker(options_of(SITE))
        self.spawn(broker.run())
        self._tunnel = TunnelServer(broker, self.address, self._app, lambda *_: None, {})
        await self._tunnel.open()

    async def _app(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket":
            await self._stream(scope, receive, send)
            return
        document = await self._answer(scope["path"])
        status = 404 if document is None else 200
        await send({"type": "http.response.start", "status": status, "headers": []})
        await send({"type": "http.response.body", "body": encode(document)})

    async def _answer(self, path: str) -> object:
        if path == "/goals":
            page = await self.history.page(GoalFilter(), limit=1000)
            return {"goals": [goal.document() for goal in page], "next_cursor": None}
        if path.startswith("/goals/"):
            goal = await self.history.get(path.removeprefix("/goals/"))
            return None if goal is None else goal.document()
        return {}

    async def _stream(self, scope: Scope, receive: Receive, send: Send) -> None:
        await receive()
        await send({"type": "websocket.accept"})
        after = parse_qs(scope["query_string"].decode()).get("after")
        subscriber = self.fanout.subscribe(WithoutFeedback())
        gone = self.spawn(self._await_end(receive, subscriber.expel))
        try:
            async for event in feed.feed(self.parts, subscriber, after=after[0] if after else None):
                await send({"type": "websocket.send", "text": event.text})
        finally:
            gone.cancel()
            self.fanout.unsubscribe(subscriber)

    @staticmethod
    async def _await_end(receive: Receive, leave: object) -> None:
        assert callable(leave)
        while (await receive())["type"] != "websocket.disconnect":
            pass
        leave()

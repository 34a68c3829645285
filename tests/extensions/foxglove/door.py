"""`/foxglove` as tests use it."""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import orjson
from websockets.sync.client import ClientConnection
from websockets.typing import Subprotocol

from tests.support.clients import open_websocket
from tests.support.doors import QUIET, Door, Headers, Stop
from tests.support.gateway import RunningGateway
from tests.support.waiting import PATIENCE

STOP = "/dock_gateway/stop"


class Client:
    """A viewer: keeps what it is offered and sent."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}

    def send(self, op: str, **fields: Any) -> None:
        self.connection.send(orjson.dumps({"op": op, **fields}).decode())

    def next(self) -> dict[str, Any]:
        data = self.connection.recv(PATIENCE)
        if isinstance(data, str):
            message: dict[str, Any] = orjson.loads(data)
        else:
            message = self.read(data)
        if message["op"] == "advertise":
            self.channels |= {each["topic"]: each for each in message["channels"]}
        if message["op"] == "advertiseServices":
            self.services |= {each["name"]: each for each in message["services"]}
        return message

    @staticmethod
    def read(data: bytes) -> dict[str, Any]:
        if data[0] == 1:
            identity, stamp_ns = struct.unpack_from("<IQ", data, 1)
            return {"op": "message", "id": identity, "stamp_ns": stamp_ns, "data": data[13:]}
        service, call, length = struct.unpack_from("<III", data, 1)
        assert data[0] == 3
        return {"op": "response", "serviceId": service, "callId": call, "data": data[13 + length :]}

    def until(self, op: str, **fields: Any) -> dict[str, Any]:
        """The next message of this kind with these fields."""
        while (message := self.next())["op"] != op or not fields.items() <= message.items():
            pass
        return message

    def channel(self, topic: str) -> dict[str, Any]:
        """The channel of a topic, as soon as it is offered."""
        while topic not in self.channels:
            self.next()
        return self.channels[topic]

    def subscribe(self, identity: int, topic: str) -> None:
        self.send("subscribe", subscriptions=[{"id": identity, "channelId": self.channel(topic)["id"]}])

    def service(self, name: str) -> int:
        """The id of a service, as soon as it is offered."""
        while name not in self.services:
            self.next()
        return int(self.services[name]["id"])

    def begin(self, name: str, request: bytes, encoding: str = "cdr", call: int = 7) -> None:
        head = struct.pack("<BIII", 2, self.service(name), call, len(encoding))
        self.connection.send(head + encoding.encode() + request)

    def call(self, name: str, request: bytes, encoding: str = "cdr") -> bytes:
        """The response of a service."""
        self.begin(name, request, encoding)
        while (message := self.next())["op"] not in {"response", "serviceCallFailure"}:
            pass
        assert message["op"] == "response", message
        assert (message["serviceId"], message["callId"]) == (self.services[name]["id"], 7)
        return bytes(message["data"])

    def ask(self, name: str, **fields: Any) -> Any:
        """The response of a service, in JSON."""
        return orjson.loads(self.call(name, orjson.dumps(fields), "json"))

    def failure(self, name: str, request: bytes, encoding: str = "cdr") -> str:
        self.begin(name, request, encoding)
        return str(self.until("serviceCallFailure", callId=7)["message"])

    def error(self, text: str) -> None:
        message = self.until("status", level=2)
        assert text in message["message"]


@contextmanager
def client_of(gateway: RunningGateway, query: str = "", **options: Any) -> Iterator[Client]:
    url = f"{gateway.url.replace('http', 'ws')}/foxglove{query}"
    options = {"subprotocols": [Subprotocol("foxglove.websocket.v1")], **options}
    with open_websocket(url, max_size=None, **options) as connection:
        yield Client(connection)


@contextmanager
def _stops(gateway: RunningGateway) -> Iterator[Stop]:
    with client_of(gateway, **QUIET) as client:

        def stop(fields: Any) -> dict[str, Any]:
            answer = orjson.loads(client.call(STOP, orjson.dumps(fields), "json"))
            report: dict[str, Any] = orjson.loads(answer["report"])
            return report

        yield stop


def _topics(gateway: RunningGateway, headers: Headers, one: str) -> set[str]:
    with client_of(gateway, additional_headers=headers) as client:
        client.channel(one)
        return set(client.channels)


DOORS = (Door("foxglove", _stops, _topics),)

"""`/rosbridge` as tests use it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import orjson
from websockets.sync.client import ClientConnection

from tests.support.clients import open_websocket
from tests.support.doors import QUIET, Door, Headers, Stop
from tests.support.gateway import RunningGateway
from tests.support.waiting import PATIENCE

FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
STOP = "/dock_gateway/stop"


class Client:
    """A client that keeps what it is sent."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.seen: list[dict[str, Any]] = []

    def send(self, op: str, **fields: Any) -> None:
        self.connection.send(orjson.dumps({"op": op, **fields}).decode())

    def next(self) -> dict[str, Any]:
        message: dict[str, Any] = orjson.loads(self.connection.recv(PATIENCE))
        self.seen.append(message)
        return message

    def until(self, op: str, **fields: Any) -> dict[str, Any]:
        """The next message of this kind with these fields."""
        while (message := self.next())["op"] != op or not fields.items() <= message.items():
            pass
        return message

    def call(self, service: str, /, **args: Any) -> Any:
        self.send("call_service", service=service, args=args, id=service)
        answer = self.until("service_response", id=service)
        assert answer["service"] == service
        assert answer["result"], answer
        return answer["values"]

    def goal(self, order: int, identity: str, **fields: Any) -> None:
        fields = {"action": "/fibonacci", "action_type": FIBONACCI, "args": {"order": order}, **fields}
        self.send("send_action_goal", id=identity, **fields)

    def error(self, text: str = "") -> str:
        """The next error."""
        message = self.until("status", level="error")
        assert text in message["msg"]
        return str(message["msg"])


@contextmanager
def client_of(gateway: RunningGateway, query: str = "", **options: Any) -> Iterator[Client]:
    url = f"{gateway.url.replace('http', 'ws')}/rosbridge{query}"
    with open_websocket(url, max_size=None, **options) as connection:
        yield Client(connection)


def stop_call(fields: Any) -> bytes:
    """A call of the service that stops."""
    return orjson.dumps({"op": "call_service", "service": STOP, "args": fields})


def stop_report(client: Client) -> dict[str, Any]:
    """The answer to such a call."""
    answer = client.until("service_response")
    assert answer["result"], answer
    report: dict[str, Any] = answer["values"]
    return report


@contextmanager
def _stops(gateway: RunningGateway) -> Iterator[Stop]:
    with client_of(gateway, **QUIET) as client:

        def stop(fields: Any) -> dict[str, Any]:
            client.connection.send(stop_call(fields).decode())
            return stop_report(client)

        yield stop


@contextmanager
def _stops_in_fragments(gateway: RunningGateway) -> Iterator[Stop]:
    with client_of(gateway, **QUIET) as client:

        def stop(fields: Any) -> dict[str, Any]:
            text = stop_call(fields).decode()
            pieces = [text[at : at + 40] for at in range(0, len(text), 40)]
            for number, piece in enumerate(pieces):
                client.send("fragment", id="f", data=piece, num=number, total=len(pieces))
            return stop_report(client)

        yield stop


def _topics(gateway: RunningGateway, headers: Headers, _: str) -> set[str]:
    with client_of(gateway, additional_headers=headers) as client:
        return set(client.call("/rosapi/topics")["topics"])


def _reads(gateway: RunningGateway, headers: Headers, topic: str) -> bool:
    with client_of(gateway, additional_headers=headers) as client:
        client.send("subscribe", topic=topic)
        while (message := client.next())["op"] != "publish":
            if message["op"] == "status" and message["level"] == "error":
                assert "not include" in message["msg"]
                return False
        return True


DOORS = (Door("rosbridge", _stops, _topics, _reads), Door("rosbridge in fragments", _stops_in_fragments))

"""A real gateway and clients that speak HTTP as the standard allows, but as few do."""

import socket
from collections.abc import Iterator
from urllib.parse import urlsplit

import orjson
import pytest
from websockets.exceptions import InvalidStatus

from tests.support.clients import connect
from tests.support.gateway import RunningGateway, ready_gateway
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros
HANDSHAKE = (
    "Connection: Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    """With a docking server, whose goals go on until they are canceled: no battery charges here."""
    with ready_gateway(shared_domain) as gateway:
        yield gateway


def ask(gateway: RunningGateway, request: str) -> bytes:
    """Send bytes, and return the head of the answer."""
    address = urlsplit(gateway.url)
    answer = b""
    with socket.create_connection((address.hostname, address.port), timeout=PATIENCE) as connection:
        connection.sendall(request.encode())
        while b"\r\n\r\n" not in answer and (piece := connection.recv(65536)):
            answer += piece
    return answer.partition(b"\r\n\r\n")[0]


def exchange(gateway: RunningGateway, handshake: bytes, frame: bytes) -> bytes:
    """Open a WebSocket, send a frame, and return the first bytes of the answer."""
    address = urlsplit(gateway.url)
    with socket.create_connection((address.hostname, address.port), timeout=PATIENCE) as connection:
        connection.sendall(handshake)
        assert b" 101 " in connection.recv(65536)
        connection.sendall(frame)
        return connection.recv(65536)


def subscribers(gateway: RunningGateway) -> int:
    found: int = gateway.http.get("/healthz").json()["subscribers"]
    return found


def test_the_head_of_a_stream_leaves_no_subscriber(gateway: RunningGateway) -> None:
    goal = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
    for path in (f"/dock/{goal}/events", f"/goals/{goal}/events", f"/goals/{goal}/export?format=csv", f"/dock/{goal}"):
        response = gateway.http.head(path)
        assert (response.status_code, response.content) == (200, b""), path
    wait_until(lambda: subscribers(gateway) == 0, "no subscriber is left")
    gateway.stop_once()


@pytest.mark.parametrize("path", ["/healthz", "/readyz", "/robots", "/metrics", "/goals", "/actions", "/", "/stop"])
def test_a_head(gateway: RunningGateway, path: str) -> None:
    head, get = gateway.http.head(path), gateway.http.get(path)
    assert (head.status_code, head.content) == (get.status_code, b"")
    assert head.headers["content-type"] == get.headers["content-type"]
    assert int(head.headers["content-length"]) > 0


def test_a_stop_over_a_websocket_whose_address_is_in_the_request_line(gateway: RunningGateway) -> None:
    """As clients send it through a proxy. The host in the line counts: no page of another one comes in."""
    address = gateway.url.replace("http", "ws")
    stop = b'{"op": "stop", "id": "1"}'
    frame = b"\x81" + bytes([0x80 | len(stop)]) + bytes(4) + stop  # a text, whose mask changes nothing
    handshake = f"GET {address}/ws HTTP/1.1\r\nHost: foreign.example\r\n{HANDSHAKE}"
    assert b'"op":"ack"' in exchange(gateway, handshake.encode(), frame)
    assert gateway.http.get("/stop").json()["latched"]
    gateway.http.delete("/stop").raise_for_status()
    for line, origin in (("ws://foreign.example", gateway.url), (address, "http://foreign.example")):
        request = f"GET {line}/ws HTTP/1.1\r\nHost: {urlsplit(gateway.url).netloc}\r\nOrigin: {origin}\r\n{HANDSHAKE}"
        assert b" 403 " in ask(gateway, request), line


def test_a_stop_with_a_byte_order_mark(gateway: RunningGateway) -> None:
    with connect(f"{gateway.url.replace('http', 'ws')}/ws") as websocket:
        websocket.send("\ufeff" + orjson.dumps({"op": "stop", "id": "1"}).decode())
        assert orjson.loads(websocket.recv(PATIENCE))["op"] == "ack"
    assert gateway.http.get("/stop").json()["latched"]
    gateway.http.delete("/stop").raise_for_status()
    gateway.http.post("/stop", content=b'\xef\xbb\xbf{"latch": false}').raise_for_status()
    assert not gateway.http.get("/stop").json()["latched"]


def test_a_name_with_its_slash(gateway: RunningGateway) -> None:
    for path in (
        "/actions/{}connect_to_charging_dock",
        "/actions/{}connect_to_charging_dock/goals",
        "/graph/topics/{}rosout",
    ):
        with_slash, without = gateway.http.get(path.format("%2F")), gateway.http.get(path.format(""))
        assert with_slash.raise_for_status().json() == without.json(), path


def test_a_websocket_of_another_page_is_one_line_of_the_log(gateway: RunningGateway) -> None:
    with pytest.raises(InvalidStatus):
        connect(f"{gateway.url.replace('http', 'ws')}/ws", origin="http://foreign.page")
    gateway.process.wait_for("a WebSocket was refused: pages of 'http://foreign.page'")
    gateway.http.get("/healthz")
    about = [line for line in gateway.process.own_lines if "foreign.page" in line or "ASGI" in line]
    assert len(about) == 1, about

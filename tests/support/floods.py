"""Clients that attack a gateway, each in a process of its own so that it does not slow whoever measures.

Each flood runs until it is ended. A connection that the gateway closes is opened again, as an attacker would.
`python -m tests.support.floods NAME HOST PORT` runs one by hand.
"""

import base64
import contextlib
import os
import resource
import selectors
import socket
import struct
import sys
import time
import zlib
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

from tests.support.installed import is_there
from tests.support.processes import Process

Address = tuple[str, int]
Flood = Callable[[Address], None]

HOST = b"Host: localhost\r\n"
CONTINUATION, TEXT, BINARY, PING = 0, 1, 2, 9
FOXGLOVE = b"Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"
FIN = 0x80


def frame(opcode: int, payload: bytes = b"", *, fin: bool = True) -> bytes:
    """A WebSocket frame of a client, masked with zeros."""
    head = opcode | (FIN if fin else 0)
    if len(payload) < 126:
        return bytes((head, 0x80 | len(payload))) + bytes(4) + payload
    if len(payload) < 65_536:
        return struct.pack("!BBH", head, 0x80 | 126, len(payload)) + bytes(4) + payload
    return struct.pack("!BBQ", head, 0x80 | 127, len(payload)) + bytes(4) + payload


def open_websocket(address: Address, path: str, headers: bytes = b"") -> socket.socket:
    """A WebSocket whose frames are written and read by hand.

    Raises:
        OSError: It was refused.
    """
    connection = socket.create_connection(address, timeout=10)
    key = base64.b64encode(os.urandom(16))
    upgrade = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: %s\r\n\r\n"
    connection.sendall(b"GET %s HTTP/1.1\r\n" % path.encode() + HOST + headers + upgrade % key)
    if b" 101 " not in connection.recv(1024).partition(b"\r\n")[0]:
        connection.close()
        raise ConnectionRefusedError("the WebSocket was refused")
    return connection


def _websocket(path: str, first: bytes, then: bytes, *, read: bool = True, headers: bytes = b"") -> Flood:
    """Open a WebSocket, send `first`, then `then` for ever; on `read`, take what the gateway answers."""

    def flood(address: Address) -> None:
        with open_websocket(address, path, headers) as connection:
            connection.sendall(first)
            connection.setblocking(False)
            with selectors.DefaultSelector() as selector:
                selector.register(connection, selectors.EVENT_WRITE | (selectors.EVENT_READ if read else 0))
                _exchange(connection, selector, then)

    return flood


def _foxglove(then: bytes, *, read: bool = True) -> Flood:
    """Send `then` for ever as a viewer."""
    return _websocket("/foxglove", b"", then, read=read, headers=FOXGLOVE)


def _exchange(connection: socket.socket, selector: selectors.BaseSelector, data: bytes) -> None:
    rest = memoryview(data)
    while True:
        for _, events in selector.select():
            if events & selectors.EVENT_READ and not connection.recv(1 << 20):
                return
            if events & selectors.EVENT_WRITE:
                with contextlib.suppress(BlockingIOError):
                    rest = rest[connection.send(rest) :] or memoryview(data)


def _request(first: bytes, then: bytes, *, pause: float = 0.0) -> Flood:
    """Send the beginning of a request, then `then` for ever."""

    def flood(address: Address) -> None:
        with socket.create_connection(address, timeout=10) as connection:
            connection.sendall(first)
            while True:
                connection.sendall(then)
                time.sleep(pause)

    return flood


def _many(count: int, first: bytes, then: bytes = b"", pause: float = 0.5) -> Flood:
    """Hold `count` connections, each of which sent `first`, and sends `then` now and then."""

    def flood(address: Address) -> None:
        _raise_limit()
        held: list[socket.socket] = []
        while True:
            while len(held) < count:
                held.append(_connect(address, first))
            held = [connection for connection in held if _goes_on(connection, then)]
            time.sleep(pause)

    return flood


def _connect(address: Address, first: bytes) -> socket.socket:
    connection = socket.socket()
    connection.settimeout(2)
    with contextlib.suppress(OSError):
        connection.connect(address)
        connection.sendall(first)
    connection.setblocking(False)
    return connection


def _goes_on(connection: socket.socket, then: bytes) -> bool:
    try:
        connection.send(then)
        if connection.recv(4096):
            return True
    except BlockingIOError:
        return True
    except OSError:
        pass
    connection.close()
    return False


def _slow_readers(path: str, count: int) -> Flood:
    """Ask for a stream on many connections, and read none of them."""
    return _many(count, b"GET %s HTTP/1.1\r\n%s\r\n" % (path.encode(), HOST))


def _slow_websockets(
    path: str, first: bytes = b"", then: bytes = frame(PING, b"x" * 125), headers: bytes = b""
) -> Flood:
    """Open streams, send `first` on each, then `then` now and then, and read none of them."""

    def flood(address: Address) -> None:
        _raise_limit()
        held = [open_websocket(address, path, headers) for _ in range(100)]
        for connection in held:
            connection.sendall(first)
        while all(_goes_on(connection, then) or True for connection in held):
            time.sleep(0.1)

    return flood


def _readers(path: str, first: bytes, count: int, headers: bytes = b"", pause: float = 0.0) -> Flood:
    """Open streams, send `first` on each after a pause, and read them as fast as they come."""

    def flood(address: Address) -> None:
        with selectors.DefaultSelector() as selector:
            for _ in range(count):
                connection = open_websocket(address, path, headers)
                time.sleep(pause)
                connection.sendall(first)
                selector.register(connection, selectors.EVENT_READ)
            while all(key.fileobj.recv(1 << 20) for key, _ in selector.select()):  # type: ignore[union-attr]
                pass

    return flood


def _downloads(path: str, count: int) -> Flood:
    """Ask for a document on some connections, read it as fast as it comes, and ask again."""

    def flood(address: Address) -> None:
        request = b"GET %s HTTP/1.1\r\n%sConnection: close\r\n\r\n" % (path.encode(), HOST)
        with selectors.DefaultSelector() as selector:
            for _ in range(count):
                selector.register(_connect(address, request), selectors.EVENT_READ)
            while True:
                for key, _ in selector.select():
                    connection = key.fileobj
                    assert isinstance(connection, socket.socket)
                    if not connection.recv(1 << 20):
                        selector.unregister(connection)
                        connection.close()
                        selector.register(_connect(address, request), selectors.EVENT_READ)

    return flood


def _sessions(path: str, first: bytes, headers: bytes = b"") -> Flood:
    """Open a WebSocket, send `first` and leave, again and again, twenty at a time."""

    def flood(address: Address) -> None:
        held: deque[socket.socket] = deque()
        while True:
            held.append(open_websocket(address, path, headers))
            held[-1].sendall(first)
            if len(held) > 20:
                held.popleft().close()

    return flood


def _raise_limit() -> None:
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


START = b"GET /healthz HTTP/1.1\r\n" + HOST
CHUNKED = b"POST /dock HTTP/1.1\r\n" + HOST + b"Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n"
LARGE = b"POST /dock HTTP/1.1\r\n" + HOST + b"Content-Type: application/json\r\nContent-Length: 990000\r\n\r\n"
ENDLESS = b"GET /healthz HTTP/1.1\r\n" + HOST + b"Content-Length: 100000000000\r\n\r\n"
FRAGMENTS = frame(CONTINUATION, fin=False) * 5_000
ROSAPI = b'{"op":"call_service","service":"/rosapi/topics"}'
PINGS = frame(PING, b"x" * 100) * 1_000


def _operation(text: bytes) -> bytes:
    """An operation of rosbridge, as a frame."""
    return frame(TEXT, text)


SUBSCRIBE = _operation(b'{"op":"subscribe","topic":"/battery_status","type":"sensor_msgs/BatteryState"}')
CALL = _operation(b'{"op":"call_service","service":"/rosapi/topics_and_raw_types","id":"flood"}')
NONSENSE = (b"dock please", b'{"op":"dock"}', b"[]", b'{"op":7}', b'{"op":"subscribe","topic":', b"[" * 20_000, b"\0")
PIECE = b'{"op":"fragment","id":"%d","num":%d,"total":10000,"data":"%s"}'
PIECES = b"".join(_operation(PIECE % (n % 9, n, b"x" * 5_000)) for n in range(1_000))
CHURN = b"".join(
    _operation(b'{"op":"subscribe","topic":"/flood%d","type":"std_msgs/String"}' % n)
    + _operation(b'{"op":"unsubscribe","topic":"/flood%d"}' % n)
    for n in range(200)
)
# Views of a large map, and large messages of clients.
VIEW_MAP = _operation(b'{"op":"subscribe","topic":"/map","type":"nav_msgs/OccupancyGrid"}')
VIEW_MAP_IN_PIECES = _operation(
    b'{"op":"subscribe","topic":"/map","type":"nav_msgs/OccupancyGrid","queue_length":1,"fragment_size":100}'
)
CALL_IN_PIECES = _operation(
    b'{"op":"call_service","service":"/rosapi/topics_and_raw_types","id":"flood","fragment_size":100}'
)
ADVERTISE = _operation(b'{"op":"advertise","topic":"/flood/path","type":"nav_msgs/Path"}')
# The longest path that is read, and one that is refused.
POSES = b'{"poses":[%s]}' % b",".join([b"{}"] * 1_600)
TOO_MANY_POSES = b'{"poses":[%s]}' % b",".join([b"{}"] * 10_000)
MARKERS = b'{"markers":[%s]}' % b",".join([b'{"points":[%s]}' % b",".join([b"{}"] * 3_000)] * 70)
PUBLISH = _operation(b'{"op":"publish","topic":"/flood/path","msg":%s}' % POSES)
PUBLISH_TOO_MUCH = _operation(b'{"op":"publish","topic":"/flood/path","msg":%s}' % TOO_MANY_POSES)
PUBLISH_MARKERS = _operation(b'{"op":"publish","topic":"/flood/markers","msg":%s}' % MARKERS)
ADVERTISE_MARKERS = _operation(b'{"op":"advertise","topic":"/flood/markers","type":"visualization_msgs/MarkerArray"}')
# Foxglove: subscriptions to channels that are not there, and binary messages that are none.
NO_CHANNELS = b",".join(b'{"id":%d,"channelId":%d}' % (n, n) for n in range(1_000))
SUBSCRIPTIONS = _operation(b'{"op":"subscribe","subscriptions":[%s]}' % NO_CHANNELS)
NOT_BINARY = (b"", b"\x01", b"\x01\0\0\0\0data", b"\x02" + b"\xff" * 12, b"\x02" + b"\0" * 500, b"\xff" * 20_000)
BINARY_NONSENSE = [frame(BINARY, data) for data in NOT_BINARY]
# The channel of the battery has the same id for each connection, as soon as it is offered.
BATTERY = zlib.crc32(b"/battery_status sensor_msgs/msg/BatteryState")
VIEW = _operation(b'{"op":"subscribe","subscriptions":[{"id":1,"channelId":%d}]}' % BATTERY)
MAP_CHANNEL = zlib.crc32(b"/map nav_msgs/msg/OccupancyGrid")
VIEW_MAP_CHANNEL = _operation(b'{"op":"subscribe","subscriptions":[{"id":1,"channelId":%d}]}' % MAP_CHANNEL)
# A frame that announces 100 GB.
ENDLESS_FRAME = struct.pack("!BBQ", FIN | TEXT, 0xFF, 100_000_000_000) + bytes(4)


def _call(tool: bytes) -> bytes:
    """A call of a tool of agents."""
    return _message(b'{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"%s","arguments":{}}}' % tool)


def _posted(path: bytes, body: bytes) -> bytes:
    """A request with a body of JSON."""
    head = b"POST %s HTTP/1.1\r\n%sContent-Type: application/json\r\nContent-Length: %d\r\n\r\n"
    return head % (path, HOST, len(body)) + body


def _message(body: bytes) -> bytes:
    """A message of an agent."""
    accept = b"Accept: application/json, text/event-stream\r\nContent-Type: application/json\r\n"
    return b"POST /mcp HTTP/1.1\r\n%s%sContent-Length: %d\r\n\r\n%s" % (HOST, accept, len(body), body)


FLOODS: dict[str, Flood] = {
    "fragments on /ws": _websocket("/ws", frame(TEXT, b"{", fin=False), FRAGMENTS),
    "fragments on /ws/feedback": _websocket("/ws/feedback", frame(TEXT, b"{", fin=False), FRAGMENTS),
    "fragments on /ws/topics": _websocket("/ws/topics?topic=/rosout", frame(TEXT, b"{", fin=False), FRAGMENTS),
    "an endless header": _request(START + b"X: ", b"x" * 65_536),
    "endless headers": _request(START, b"a: b\r\n" * 10_000),
    "a header of 5 MB": _request(START + b"X: " + b"x" * 5_000_000, b"\r\n\r\n", pause=0.05),
    "a byte a second": _many(200, START, b"x", pause=1.0),
    "half-open connections": _many(1_000, b""),
    "half-sent requests": _many(1_000, START),
    "pings": _websocket("/ws/feedback", b"", PINGS),
    "empty pings": _websocket("/ws", b"", frame(PING) * 10_000),
    "unread pings": _websocket("/ws/feedback", b"", PINGS, read=False),
    "commands": _websocket("/ws", b"", frame(TEXT, b'{"op":"ping"}') * 1_000),
    "unread commands": _websocket("/ws", b"", frame(TEXT, b'{"op":"ping"}') * 1_000, read=False),
    "operations on /rosbridge": _websocket("/rosbridge", b"", frame(TEXT, ROSAPI) * 1_000),
    "tiny chunks": _request(CHUNKED, b"1\r\n \r\n" * 10_000),
    "bodies without end": _many(100, LARGE, b"x" * 20_000, pause=0.1),
    "an unwanted body": _request(ENDLESS, b"x" * 65_536),
    "pipelined requests": _request(b"", (START + b"\r\n") * 100),
    "connections": _many(100, START + b"Connection: close\r\n\r\n", pause=0.0),
    "calls of agents": _many(20, _call(b"list_robots"), _call(b"list_alerts"), pause=0.01),
    "unread calls of agents": _request(b"", _call(b"list_robots") * 100),
    "garbage of agents": _many(20, b"", b"".join(map(_message, NONSENSE)), pause=0.01),
    "fragments on /rosbridge": _websocket("/rosbridge", frame(TEXT, b"{", fin=False), FRAGMENTS),
    "garbage on /rosbridge": _websocket("/rosbridge", b"", b"".join(map(_operation, NONSENSE)) * 10),
    "an endless message on /rosbridge": _websocket("/rosbridge", ENDLESS_FRAME, b"x" * 65_536),
    "pieces of messages on /rosbridge": _websocket("/rosbridge", b"", PIECES),
    "unread calls on /rosbridge": _websocket("/rosbridge", b"", CALL * 1_000, read=False),
    "subscriptions on /rosbridge": _websocket("/rosbridge", b"", CHURN),
    "slow readers of /rosbridge": _slow_websockets("/rosbridge", SUBSCRIBE + CALL * 100),
    "sessions of /rosbridge": _sessions("/rosbridge", SUBSCRIBE + CALL),
    "garbage on /foxglove": _foxglove(b"".join([*map(_operation, NONSENSE), *BINARY_NONSENSE]) * 10),
    "slow readers of /foxglove": _slow_websockets("/foxglove", VIEW * 100, VIEW, FOXGLOVE),
    "sessions of /foxglove": _sessions("/foxglove", SUBSCRIPTIONS, FOXGLOVE),
    "unread answers": _slow_readers("/openapi.json", 200),
    "a map in pieces on /rosbridge": _readers("/rosbridge", VIEW_MAP_IN_PIECES, 1),
    "answers in pieces on /rosbridge": _websocket("/rosbridge", b"", CALL_IN_PIECES),
    "paths on /rosbridge": _websocket("/rosbridge", ADVERTISE, PUBLISH),
    "too long paths on /rosbridge": _websocket("/rosbridge", ADVERTISE, PUBLISH_TOO_MUCH),
    "markers on /rosbridge": _websocket("/rosbridge", ADVERTISE_MARKERS, PUBLISH_MARKERS),
    "paths by POST": _many(3, b"", _posted(b"/topics/flood/path?type=nav_msgs/msg/Path", POSES), pause=0.05),
    "viewers of a large map on /rosbridge": _readers("/rosbridge", VIEW_MAP, 3),
    "viewers of map.png": _downloads("/map.png", 10),
    "viewers of a large topic": _readers("/ws/topics?topic=/map", b"", 3),
    "viewers of a large map on /foxglove": _readers("/foxglove", VIEW_MAP_CHANNEL, 3, FOXGLOVE, 0.3),
    "slow event streams": _slow_websockets("/ws/feedback?include=battery,cmd_vel,system,robots,scene"),
}

# The extensions that floods are about, by the last word of their names.
EXTENSIONS = {"/rosbridge": "rosbridge", "/foxglove": "foxglove", "agents": "agents", "map.png": "maps"}
FLOODS = {name: flood for name, flood in FLOODS.items() if is_there(name.split()[-1], EXTENSIONS)}
# Floods of large messages: the memory for what has been read of them is used again, and not given back.
LONG = frozenset({"paths on /rosbridge", "too long paths on /rosbridge", "markers on /rosbridge", "paths by POST"})
# Floods about a large topic, which `tests.support.hostile_node grid` publishes: the bytes of its messages.
MAPS = {
    "a map in pieces on /rosbridge": 4_000_000,
    "viewers of a large map on /rosbridge": 16_000_000,
    "viewers of a large map on /foxglove": 16_000_000,
    "viewers of a large topic": 16_000_000,
    "viewers of map.png": 16_000_000,
}
MAPS = {name: size for name, size in MAPS.items() if name in FLOODS}


def run(name: str, address: Address) -> None:
    """Flood a gateway until this process is ended."""
    print("flooding", flush=True)
    flood = FLOODS[name]
    while True:
        with contextlib.suppress(OSError):
            flood(address)


@contextmanager
def flooding(name: str, url: str, processes: int = 1) -> Iterator[None]:
    """Flood the gateway at `url` by some attackers at once."""
    address = urlsplit(url)
    with contextlib.ExitStack() as stack:
        for _ in range(processes):
            command = (sys.executable, "-m", __spec__.name, name, str(address.hostname), str(address.port))
            process = stack.enter_context(Process(*command, env=dict(os.environ)))
            process.wait_for("flooding")
        yield


if __name__ == "__main__":
    run(sys.argv[1], (sys.argv[2], int(sys.argv[3])))

"""A stop of a real gateway, however its request line is written: it is carried out, or clearly refused."""

import socket
from urllib.parse import urlsplit

import orjson
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.support.gateway import RunningGateway
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.ros


def ask(gateway: RunningGateway, line: bytes, host: bytes = b"localhost") -> tuple[int, str]:
    """Send a request line with usual headers. Status of the answer, and its code if it is a problem."""
    address = urlsplit(gateway.url)
    answer = b""
    with socket.create_connection((address.hostname, address.port), timeout=PATIENCE) as connection:
        connection.sendall(line + b"\r\nHost: " + host + b"\r\nConnection: close\r\n\r\n")
        while piece := connection.recv(65536):
            answer += piece
    head, _, body = answer.partition(b"\r\n\r\n")
    document = orjson.loads(body) if body.startswith(b"{") else {}
    return int(head.split(b" ")[1]), document.get("code", "")


def is_stopped(gateway: RunningGateway) -> bool:
    """Whether the robot is stopped; it is released then."""
    return bool(gateway.http.get("/stop").json()["latched"]) and gateway.http.delete("/stop").status_code == 200


STOPS = (
    b"POST /stop HTTP/1.1",
    b"POST /stop HTTP/1.0",
    b"\r\nPOST /stop HTTP/1.1",
    b"\r\n\r\n\r\nPOST /stop HTTP/1.1",
    b"post /stop HTTP/1.1",
    b"POST //stop HTTP/1.1",
    b"POST /stop/ HTTP/1.1",
    b"POST /STOP HTTP/1.1",
    b"POST /stop# HTTP/1.1",
    b"POST /stop? HTTP/1.1",
    b"POST /%73top HTTP/1.1",
    b"POST /./stop HTTP/1.1",
    b"POST /x/../stop HTTP/1.1",
    b"POST /stop;v=1 HTTP/1.1",
    b"POST /stop?robot=/ HTTP/1.1",
    b"POST /stop?x HTTP/1.1",
    b"POST /stop?robot=/nowhere HTTP/1.1",
    b"POST http://127.0.0.1:8000/stop HTTP/1.1",
    b"POST http://localhost/stop HTTP/1.1",
    b"POST https://127.0.0.1//STOP/?robot=/ HTTP/1.1",
    b"POST HTTP://[::1]:8000/stop HTTP/1.0",
)
REFUSALS = {
    b"POST http://foreign.example/stop HTTP/1.1": (403, "host_not_allowed"),
    b"POST http://user@localhost/stop HTTP/1.1": (400, "malformed_request"),
    b"POST http://localhost\\@foreign.example/stop HTTP/1.1": (400, "malformed_request"),
    b"POST http://localhost,foreign.example/stop HTTP/1.1": (403, "host_not_allowed"),
    b"POST ftp://localhost/stop HTTP/1.1": (400, "malformed_request"),
    b"POST stop HTTP/1.1": (400, "malformed_request"),
    b"POST * HTTP/1.1": (400, "malformed_request"),
    b"OPTIONS * HTTP/1.1": (400, "malformed_request"),
    b"CONNECT localhost:8000 HTTP/1.1": (400, "malformed_request"),
    b"POST  /stop HTTP/1.1": (400, "malformed_request"),
    b"POST /stop  HTTP/1.1": (400, "malformed_request"),
    b"POST /stop HTTP/1.1 ": (400, "malformed_request"),
    b" POST /stop HTTP/1.1": (400, "malformed_request"),
    b"POST /stop": (400, "malformed_request"),
    b"POST /stop HTTP/2.0": (400, "malformed_request"),
    b"POST /st op HTTP/1.1": (400, "malformed_request"),
    b"PUT /stop HTTP/1.1": (405, "method_not_allowed"),
    b"STOP /stop HTTP/1.1": (405, "method_not_allowed"),
    b"CONNECT /stop HTTP/1.1": (405, "method_not_allowed"),
    b"POST /stops HTTP/1.1": (404, "not_found"),
    b"POST /stop%00 HTTP/1.1": (404, "not_found"),
    b"POST /x/stop HTTP/1.1": (404, "not_found"),
    b"POST /stop/../dock HTTP/1.1": (404, "not_found"),
}


@pytest.mark.parametrize("line", STOPS)
def test_a_stop(gateway: RunningGateway, line: bytes) -> None:
    assert ask(gateway, line) == (200, "")
    assert is_stopped(gateway)


@pytest.mark.parametrize("line", REFUSALS)
def test_what_is_refused(gateway: RunningGateway, line: bytes) -> None:
    assert ask(gateway, line) == REFUSALS[line]
    assert not is_stopped(gateway)


def test_a_stop_without_a_host(gateway: RunningGateway) -> None:
    """The address in the line counts, whatever the header says; HTTP/1.0 needs none."""
    assert ask(gateway, b"POST http://127.0.0.1/stop HTTP/1.1", b"foreign.example") == (200, "")
    assert is_stopped(gateway)
    assert ask(gateway, b"GET http://foreign.example/robots HTTP/1.1") == (403, "host_not_allowed")


def test_every_route_takes_a_whole_address(gateway: RunningGateway) -> None:
    address = gateway.url.encode()
    assert ask(gateway, b"GET " + address + b"/robots HTTP/1.1") == (200, "")
    assert ask(gateway, b"GET " + address + b" HTTP/1.1")[0] == 200
    assert ask(gateway, b"POST " + address + b"/dock?robots=/ HTTP/1.1") == (422, "invalid_field")
    assert ask(gateway, b"GET " + address + b"/nowhere HTTP/1.1") == (404, "not_found")
    assert ask(gateway, b"DELETE " + address + b"/stop HTTP/1.1") == (200, "")


METHODS = st.sampled_from(["POST"] * 6 + ["post", "PUT", "PATCH", "STOP", "CONNECT", "P\0ST", ""])
SPACES = st.sampled_from([" "] * 12 + ["  ", "\t", "", "\xa0", "\x0b"])
PREFIXES = st.sampled_from(
    ["/"] * 6 + ["", "http://", "http://localhost/", "https://[::1]:1/", "http://a/", "*", "\xff"]
)
PARTS = ("/", "stop", "STOP", "s", "top", "%73top", "%2f", "%", "..", ".", ";v=1", "#", "?", "?robot=/", "robot", "x")
TARGETS = st.lists(st.sampled_from(PARTS), max_size=8).map("".join)
VERSIONS = st.sampled_from(["HTTP/1.1"] * 8 + ["HTTP/1.0", "HTTP/1.9", "HTTP/2.0", "http/1.1", "HTTP/1", "HTTP/11", ""])
ENDS = st.sampled_from([""] * 6 + [" ", "\r", "\0"])
LINES = st.tuples(METHODS, SPACES, PREFIXES, TARGETS, SPACES, VERSIONS, ENDS).map("".join)


@given(line=LINES)
@example(line="POST /stop HTTP/1.1")
@settings(max_examples=300)
def test_any_request_line(gateway: RunningGateway, line: str) -> None:
    """It is a stop, or a clear error: never ignored, never a failure of the gateway, never without an answer."""
    status, code = ask(gateway, line.encode("latin-1"))
    assert (status, code) == (200, "") or (400 <= status < 500 and code)
    assert is_stopped(gateway) is (status == 200)


def test_none_of_this_sent_a_goal_or_broke_anything(gateway: RunningGateway) -> None:
    assert gateway.http.get("/goals").json()["goals"] == []
    assert "Traceback" not in gateway.process.output
    assert "[ERROR]" not in gateway.process.output

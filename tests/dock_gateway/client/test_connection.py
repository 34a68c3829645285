"""How a client reaches a gateway, resumes a stream and gives up."""

from urllib.parse import parse_qs, urlsplit

import httpx2
import pytest
from websockets.exceptions import ConnectionClosedError, InvalidStatus
from websockets.frames import Close
from websockets.http11 import Headers, Response

from dock_gateway.client import ClientError, GatewayRefused, GatewayUnreachable
from dock_gateway.client.calls import robots
from dock_gateway.client.connection import Connection, ReadPosition, Retry
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import encode

URL = "http://robot.example:8000"


@pytest.fixture
def connection() -> Connection:
    """Of a client that a gateway has answered before."""
    connection = Connection(URL, "dgw_secret", None, timeout=15.0, patience=3600.0)
    connection.reached = True
    return connection


def refused(status: int, body: bytes = b"") -> InvalidStatus:
    return InvalidStatus(Response(status, "", Headers(), body))


def message(kind: str, **fields: object) -> bytes:
    return encode({"type": kind, "time": utc_now(), **fields})


def after(reading: ReadPosition) -> str | None:
    return parse_qs(urlsplit(reading.url).query).get("after", [None])[0]


@pytest.mark.parametrize(
    ("url", "direct"),
    [
        ("http://127.0.0.1:8000", True),
        ("http://localhost:8000", True),
        ("http://[::1]:8000", True),
        ("https://robot.example", False),
        ("http://localhost.example", False),
    ],
)
def test_no_proxy_stands_before_this_machine(url: str, direct: bool) -> None:
    connection = Connection(url, None, None, 15.0, 60.0)
    assert connection.http_options["trust_env"] is not direct
    assert connection.stream_options["proxy"] is (None if direct else True)


@pytest.mark.parametrize("url", ["localhost:8000", "http://", "http://[::1", "http://localhost:99999", "ws://robot"])
def test_what_is_no_address_is_said_in_a_sentence(url: str) -> None:
    with pytest.raises(ClientError, match="is not the address of a gateway"):
        Connection(url, None, None, 15.0, 60.0)


def test_the_token_is_sent_over_both_protocols(connection: Connection) -> None:
    header = {"Authorization": "Bearer dgw_secret"}
    assert connection.http_options["headers"] == connection.stream_options["additional_headers"] == header


def test_a_stream_resumes_after_the_largest_id_and_shows_no_event_twice(connection: Connection) -> None:
    reading = ReadPosition(connection, {"goal_id": "g", "include": ["battery", "stop"]}, None)
    assert reading.url == "ws://robot.example:8000/ws/feedback?goal_id=g&include=battery&include=stop"
    assert after(reading) is None
    assert reading.read(message("snapshot", id="3", goals=[]))
    assert after(reading) == "3"
    assert reading.read(message("feedback", id="5", goal_id="g"))
    assert reading.read(message("status", id="4", goal_id="g")), "from another gateway, late"
    assert reading.read(message("feedback", id="5", goal_id="g")) is None
    for position in ("5", "7", "7"):
        assert reading.read(message("heartbeat", id=position))
        assert after(reading) == position


def test_delays_grow_until_an_attempt_succeeds(connection: Connection) -> None:
    retry = Retry(connection)
    first, *_, last = [retry.failed(OSError()) for _ in range(10)]
    assert first <= 0.1
    assert 1.0 <= last <= 2.0
    retry.succeeded()
    assert retry.failed(refused(503)) <= 0.1


def test_a_gateway_that_was_never_there_is_not_waited_for(connection: Connection) -> None:
    connection.reached = False
    with pytest.raises(GatewayUnreachable, match="no gateway answers at"):
        Retry(connection).failed(OSError("refused"))


def test_patience_ends(connection: Connection) -> None:
    connection.patience = 0.0
    with pytest.raises(GatewayUnreachable):
        Retry(connection).failed(OSError())


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (refused(404, b'{"code": "goal_not_found", "detail": "no such goal"}'), "goal_not_found"),
        (refused(401, b"<html>"), "401"),
        (ConnectionClosedError(Close(4401, "invalid_token"), None), "invalid_token"),
    ],
)
def test_a_refusal_is_final(connection: Connection, error: Exception, code: str) -> None:
    with pytest.raises(GatewayRefused) as refusal:
        Retry(connection).failed(error)
    assert refusal.value.code == code


@pytest.mark.parametrize(
    ("status", "body", "said"),
    [
        (200, b"<html>", "is not a dock-gateway"),
        (200, b'{"robots": 7}', "is not a dock-gateway"),
        (200, b"", "is not a dock-gateway"),
        (301, b"", "301: the answer does not come from"),
        (502, b"<html>", "502: the answer does not"),
    ],
)
def test_an_answer_that_is_not_from_a_gateway_is_said(
    connection: Connection, status: int, body: bytes, said: str
) -> None:
    with pytest.raises(ClientError, match=said):
        connection.read(httpx2.Response(status, content=body), robots().read)

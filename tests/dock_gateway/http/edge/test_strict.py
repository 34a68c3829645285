"""Requests that can be read in two ways are refused, before any application sees them."""

from itertools import combinations, pairwise

import h11
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from dock_gateway.http.edge.strict import StrictConnection
from tests.support.edge import HOST, code, serving

seen: list[bytes] = []


async def note(request: Request) -> Response:
    try:
        body = await request.body()
    except ClientDisconnect:
        return PlainTextResponse("the body was none")
    seen.append(body)
    return PlainTextResponse(f"{request.method} {request.url.path} of {request.headers['host']}: {body.decode()}")


app = Starlette(routes=[Route("/{path:path}", note, methods=["GET", "POST"])])
POST = b"POST /dock HTTP/1.1\r\n" + HOST
CHUNKED = b"Transfer-Encoding: chunked\r\n"
END = b"Connection: close\r\n\r\n"
SMUGGLED = b"0\r\n\r\nGET /smuggled HTTP/1.1\r\nHost: x\r\n\r\n"
REFUSED = {
    "both lengths": POST + CHUNKED + b"Content-Length: 4\r\n\r\n" + SMUGGLED,
    "both, the other way round": POST + b"Content-Length: 4\r\n" + CHUNKED + b"\r\n" + SMUGGLED,
    "chunks in HTTP/1.0": b"POST /dock HTTP/1.0\r\n" + HOST + CHUNKED + b"\r\n" + SMUGGLED,
    "the same length twice": POST + b"Content-Length: 0\r\ncontent-length: 0\r\n\r\n",
    "the same length twice in a line": POST + b"Content-Length: 0, 0\r\n\r\n",
    "two lengths": POST + b"Content-Length: 0\r\nContent-Length: 40\r\n\r\n" + SMUGGLED,
    "a signed length": POST + b"Content-Length: +0\r\n\r\n",
    "a negative length": POST + b"Content-Length: -1\r\n\r\n",
    "a length in hexadecimal": POST + b"Content-Length: 0x4\r\n\r\n",
    "no length": POST + b"Content-Length:\r\n\r\n",
    "a folded header": POST + b"X: a\r\n b\r\n\r\n",
    "a folded length": POST + b"Content-Length:\r\n 4\r\n\r\n",
    "a header folded with a tab": POST + b"X: a\r\n\tb\r\n\r\n",
    "a first line that is folded": b"POST /dock HTTP/1.1\r\n X: a\r\n" + HOST + b"\r\n",
    "line feeds alone": b"POST /dock HTTP/1.1\nHost: localhost\n\n",
    "one line feed alone": POST + b"X: a\nY: b\r\n\r\n",
    "an end with a line feed alone": POST + b"X: a\r\n\n",
    "a carriage return alone": POST + b"X: a\rY: b\r\n\r\n",
    "a space before the colon": POST + b"Content-Length : 0\r\n\r\n",
    "a tab before the colon": POST + b"Content-Length\t: 0\r\n\r\n",
    "no name": POST + b": a\r\n\r\n",
    "NUL in a value": POST + b"X: a\0b\r\n\r\n",
    "NUL in a name": POST + b"X\0: a\r\n\r\n",
    "NUL in the target": b"POST /do\0ck HTTP/1.1\r\n" + HOST + b"\r\n",
    "two spaces": b"POST  /dock HTTP/1.1\r\n" + HOST + b"\r\n",
    "a space at the end": b"POST /dock HTTP/1.1 \r\n" + HOST + b"\r\n",
    "a tab": b"POST\t/dock HTTP/1.1\r\n" + HOST + b"\r\n",
    "no version": b"POST /dock\r\n" + HOST + b"\r\n",
    "another version": b"POST /dock HTTP/2.0\r\n" + HOST + b"\r\n",
    "the preface of HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "two hosts": POST + HOST + b"\r\n",
    "a tunnel": b"CONNECT 127.0.0.1:22 HTTP/1.1\r\n" + HOST + b"\r\n",
    "the whole server": b"OPTIONS * HTTP/1.1\r\n" + HOST + b"\r\n",
    "a chunk without its end": POST + CHUNKED + b"\r\n5\r\nhelloXX0\r\n\r\n",
    "a chunk of negative size": POST + CHUNKED + b"\r\n-1\r\n\r\n",
    "a chunk whose size ends with a line feed": POST + CHUNKED + b"\r\n5\nhello\r\n0\r\n\r\n",
    "a trailer that ends with a line feed": POST + CHUNKED + b"\r\n5\r\nhello\r\n0\r\nX: a\n\r\n",
    "trailers that end with a line feed": POST + CHUNKED + b"\r\n5\r\nhello\r\n0\r\n\n",
    "a folded trailer": POST + CHUNKED + b"\r\n5\r\nhello\r\n0\r\nX: a\r\n b\r\n\r\n",
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("size", [100_000, 1], ids=["at once", "byte by byte"])
async def test_what_can_be_read_in_two_ways(name: str, size: int, caplog: pytest.LogCaptureFixture) -> None:
    request = REFUSED[name]
    seen.clear()
    async with serving(app) as edge:
        answer = await edge.ask(*(request[at : at + size] for at in range(0, len(request), size)))
    assert code(answer) == (400, "malformed_request")
    assert answer.count(b"\r\nDate: ") == 1, "what follows is no request"
    assert not seen
    assert not [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")]


@pytest.mark.parametrize("size", [100_000, 1], ids=["at once", "byte by byte"])
async def test_empty_lines_before_a_request(size: int) -> None:
    """Old clients send one after a body. More than a few are refused; so are too many headers after them."""
    headers = b"".join(b"X: y\r\n" for _ in range(200))
    async with serving(app) as edge:
        for lines, end, status in ((1, END, 200), (4, END, 200), (5, END, 400), (1, headers + END, 431)):
            request = b"\r\n" * lines + b"POST /stop HTTP/1.1\r\n" + HOST + end
            answer = await edge.ask(*(request[at : at + size] for at in range(0, len(request), size)))
            assert int(answer.split(b" ")[1]) == status, lines


@pytest.mark.parametrize("coding", [b"gzip, chunked", b"chunked, chunked", b"identity", b"xchunked", b'"chunked"'])
async def test_other_transfer_codings(coding: bytes) -> None:
    async with serving(app) as edge:
        answer = await edge.ask(POST + b"Transfer-Encoding: " + coding + b"\r\n\r\n" + SMUGGLED)
    assert code(answer) == (501, "malformed_request")
    assert answer.count(b"\r\nDate: ") == 1


@pytest.mark.parametrize("trailer", [b"", b"X: y\r\n"], ids=["no trailer", "a trailer"])
def test_chunks_in_pieces_that_end_anywhere(trailer: bytes) -> None:
    """Wherever two pieces end, and byte by byte."""
    head = POST + CHUNKED + b"\r\n"
    request = head + b"5;a=b\r\nhello\r\n2\r\n\n\n\r\n0\r\n" + trailer + b"\r\n"
    ends = range(len(head), len(request))
    for cuts in [*combinations(ends, 2), tuple(ends)]:
        connection = StrictConnection(10_000)
        body = b""
        for start, end in pairwise((0, *cuts, len(request))):
            connection.receive_data(request[start:end])
            while (event := connection.next_event()) not in (h11.NEED_DATA, h11.PAUSED):
                body += bytes(event.data) if isinstance(event, h11.Data) else b""
        assert (body, connection.their_state) == (b"hello\n\n", h11.DONE), [request[:cut] for cut in cuts]


@given(sizes=st.lists(st.integers(1, 9), max_size=40), trailer=st.booleans())
@settings(max_examples=25)
async def test_chunks_in_pieces_of_any_size(sizes: list[int], trailer: bool) -> None:
    """None of the checks mistakes where a piece ends for where a line ends."""
    request = (
        POST + CHUNKED + END + b"5;a=b\r\nhello\r\n2\r\n\n\n\r\n0\r\n" + (b"X: y\r\n" if trailer else b"") + b"\r\n"
    )
    pieces, at = [], 0
    for size in sizes:
        pieces.append(request[at : at + size])
        at += size
    async with serving(app) as edge:
        answer = await edge.ask(*filter(None, pieces), *([request[at:]] if request[at:] else []))
    assert answer.endswith(b"POST /dock of localhost: hello\n\n")


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"GET http://robots.example:81/x?y HTTP/1.1", b"GET /x of robots.example:81: "),
        (b"POST http://robots.example//stop/ HTTP/1.1", b"POST /stop of robots.example: "),
        (b"post /STOP HTTP/1.1", b"POST /stop of localhost: "),
        (b"POST /stop HTTP/1.0", b"POST /stop of localhost: "),
    ],
)
async def test_the_address_in_the_line_counts(line: bytes, answer: bytes) -> None:
    async with serving(app) as edge:
        assert (await edge.ask(line + b"\r\n" + HOST + END)).endswith(answer)


async def test_a_client_of_http_1_0_need_not_name_the_host() -> None:
    async with serving(app) as edge:
        answer = await edge.ask(b"POST /stop HTTP/1.0\r\n\r\n")
        assert answer.endswith(f"POST /stop of 127.0.0.1:{edge.port}: ".encode())

"""What is sent over HTTP: headers, signature, and what comes of it."""

import asyncio
import gzip
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from itertools import chain, repeat

import pytest

from dock_gateway.extensions.webhooks.sender import Sender, is_secret, new_secret, sign
from tests.support.webhooks import Receiver


@pytest.fixture
async def sender(request: pytest.FixtureRequest) -> AsyncIterator[Sender]:
    sender = Sender(**getattr(request, "param", {}))
    yield sender
    await sender.close()


def test_the_signature_is_that_of_standard_webhooks() -> None:
    """With the example of the standard's own libraries."""
    headers = sign(
        "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
        "msg_p5jXN8AQM9LWM0D4loKWxJek",
        datetime.fromtimestamp(1614265330.9, UTC),
        b'{"test": 2432232314}',
    )
    assert headers == {
        "webhook-id": "msg_p5jXN8AQM9LWM0D4loKWxJek",
        "webhook-timestamp": "1614265330",
        "webhook-signature": "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
    }


def test_secrets() -> None:
    assert is_secret(new_secret())
    assert new_secret() != new_secret()
    for text in ("", "whsec_", "whsec_c2hvcnQ=", "MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", "whsec_ü", "whsec_" + "AAAA" * 22):
        assert not is_secret(text)


async def test_certificates_that_cannot_be_read_are_an_answer(sender: Sender, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", "/nowhere/ca.pem")
    answer = await sender.send("https://127.0.0.1:1/", {}, b"{}")
    assert answer.status_code is None
    assert answer.error is not None
    assert "No such file" in answer.error


async def test_an_event_is_sent_once_and_redirects_are_not_followed(sender: Sender, receiver: Receiver) -> None:
    receiver.answers += [200, 302, 500]
    answers = [await sender.send(receiver.url, {"webhook-id": "1"}, b"{}") for _ in range(3)]
    assert [(answer.status_code, answer.error) for answer in answers] == [
        (200, None),
        (302, "the answer was 302"),
        (500, "the answer was 500"),
    ]
    assert len(receiver.bodies) == 3
    (first, *_) = receiver.headers
    assert (first["webhook-id"], first["content-type"]) == ("1", "application/json")
    assert first["user-agent"].startswith("dock-gateway/")


async def test_what_does_not_answer_is_an_error(sender: Sender, receiver: Receiver) -> None:
    assert (await sender.send("http://127.0.0.1:1/", {}, b"")).error is not None
    for address in ("http://no-such-host.invalid/", "https" + receiver.url[4:]):
        answer = await sender.send(address, {}, b"{}")
        assert (answer.status_code, (answer.error or "")[:15]) == (None, "no connection: ")


@pytest.mark.parametrize("sender", [{"timeout": 0.3}], indirect=True)
async def test_what_answers_too_late_is_an_error(sender: Sender, receiver: Receiver) -> None:
    receiver.release = threading.Event()
    answer = await sender.send(receiver.url, {}, b"{}")
    assert (answer.status_code, answer.error) == (None, "no answer within 0.3 s")


@asynccontextmanager
async def answering(*pieces: bytes, pause: float = 0.0) -> AsyncIterator[tuple[str, list[bytes]]]:
    """A receiver that sends these bytes and the last of them for ever; its address, and the heads that it got."""
    heads: list[bytes] = []
    tasks: set[asyncio.Task[None]] = set()

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            heads.append(await reader.readuntil(b"\r\n\r\n"))
            for piece in chain(pieces, repeat(pieces[-1])):
                writer.write(piece)
                await writer.drain()
                await asyncio.sleep(pause)
        finally:
            writer.transport.abort()

    def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        tasks.add(asyncio.create_task(answer(reader, writer)))

    server = await asyncio.start_server(accept, "127.0.0.1", 0)
    try:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/hook", heads
    finally:
        server.close()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.sleep(0)  # aborted transports close their sockets


@pytest.mark.parametrize(
    ("pieces", "status"),
    [
        ([b"HTTP/1.1 200 OK\r\nContent-Encoding: gzip\r\n\r\n", gzip.compress(bytes(10_000_000))], 200),  # a bomb
        ([b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999999\r\n\r\n", b"x" * 65_536], 200),  # without end
        ([b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n", b"5\r\nhello\r\n"], 200),
        ([b"HTTP/1.1 200 OK\r\n", b"X-More: " + b"x" * 8000 + b"\r\n"], None),
        ([b"HTTP/1.1 100 Continue\r\n\r\n"], None),
        ([b"\0" * 1000], None),
        ([b"HTTP/1.1 200 OK\r\nX: a\nb\r\n\r\n", b"x"], 200),
    ],
)
@pytest.mark.parametrize("sender", [{"timeout": 2.0}], indirect=True)
async def test_an_answer_takes_neither_memory_nor_time(sender: Sender, pieces: list[bytes], status: int | None) -> None:
    """Only the status is read, whatever follows, for ever."""
    async with answering(*pieces) as (url, heads):
        answer = await asyncio.wait_for(sender.send(url, {}, b"{}"), 10)
        assert answer.status_code == status or (answer.status_code is None and answer.error is not None)
        assert len(heads) == 1


@pytest.mark.parametrize("sender", [{"timeout": 0.5}], indirect=True)
async def test_an_answer_that_comes_byte_by_byte_is_given_up(sender: Sender) -> None:
    async with answering(b"H", b"T", b"T", b"P", b"/", pause=0.1) as (url, _):
        assert (await asyncio.wait_for(sender.send(url, {}, b"{}"), 10)).status_code is None


async def test_a_redirect_to_the_own_network_is_not_followed(sender: Sender, receiver: Receiver) -> None:
    for status in (301, 302, 303, 307, 308):
        head = f"HTTP/1.1 {status} Go\r\nLocation: {receiver.url}\r\nContent-Length: 0\r\n\r\n".encode()
        async with answering(head) as (url, _):
            assert (await sender.send(url, {}, b"{}")).status_code == status
    assert receiver.bodies == []


async def test_no_cookie_is_kept(sender: Sender) -> None:
    """Webhooks may be at one host: what one receiver sets is not sent to another one, and does not pile up."""
    head = b"HTTP/1.1 204 No Content\r\nSet-Cookie: a=secret; Path=/\r\nConnection: close\r\n\r\n"
    async with answering(head) as (url, heads):
        for _ in range(2):
            assert (await sender.send(url, {}, b"{}")).status_code == 204
    assert len(heads) == 2
    assert not any(b"cookie" in each.lower() for each in heads)

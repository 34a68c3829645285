"""What is sent over HTTP: headers, signature, and what comes of it."""

import threading
from collections.abc import AsyncIterator, Iterator
from datetime import UTC, datetime

import pytest

from dock_gateway.notifications import sender as sender_module
from dock_gateway.notifications.sender import Sender, is_secret, new_secret, sign
from tests.support.webhooks import Receiver, running_receiver


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    with running_receiver() as receiver:
        yield receiver


@pytest.fixture
async def sender() -> AsyncIterator[Sender]:
    sender = Sender()
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


async def test_what_does_not_answer_is_an_error(
    sender: Sender, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert (await sender.send("http://127.0.0.1:1/", {}, b"")).error is not None
    for address in ("http://no-such-host.invalid/", "https" + receiver.url[4:]):
        answer = await sender.send(address, {}, b"{}")
        assert (answer.status_code, (answer.error or "")[:15]) == (None, "no connection: ")
    monkeypatch.setattr(sender_module, "TIMEOUT", 0.3)
    receiver.release = threading.Event()
    answer = await sender.send(receiver.url, {}, b"{}")
    assert (answer.status_code, answer.error) == (None, "no answer within 0.3 s")

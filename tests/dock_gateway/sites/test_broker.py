"""The connection to a real NATS server: it comes again, and sends nothing late."""

import asyncio
import logging
from dataclasses import replace
from pathlib import Path

import nkeys
import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.sites.broker import Broker, BrokerOptions, NoResponder, open_broker
from dock_gateway.sites.subscription import MAX_MESSAGES, SiteMessage
from tests.support.certificates import Authority
from tests.support.nats import nats_server
from tests.support.waiting import until

USERS = """authorization { users: [ { user: "site", password: "s3cret@1", permissions: {
  publish: ["good.>", "_INBOX.>"], subscribe: ["good.>", "_INBOX.site.>"]
} } ] }"""


def options(*urls: str, **changes: object) -> BrokerOptions:
    return replace(BrokerOptions(urls, None, None, "test", "_INBOX.site", waits=(0.01, 0.1)), **changes)


class Heard:
    """Keeps what it hears."""

    def __init__(self) -> None:
        self.data: list[bytes] = []

    async def __call__(self, received: SiteMessage) -> None:
        self.data.append(received.data)
        await received.reply(b"heard " + received.data)


async def publish(broker: Broker, subject: str, data: bytes) -> None:
    """Publish as soon as there is a connection."""
    await until(lambda: broker.connected)
    await broker.publish(subject, data)


async def test_requests_subscriptions_and_nobody_there(tmp_path: Path) -> None:
    with nats_server(tmp_path) as server:
        async with open_broker(options(server.url)) as one, open_broker(options(server.url)) as other:
            heard = Heard()
            subscription = await one.subscribe("good.*", heard)  # before there is a connection
            await until(lambda: one.connected and other.connected)
            assert await other.request("good.a", b"1", 60) == b"heard 1"
            later = await one.subscribe("later", heard)
            await one.flush(60)
            assert await other.request("later", b"2", 60) == b"heard 2"
            await subscription.close()
            await subscription.close()
            await one.flush(60)
            with pytest.raises(NoResponder):
                await other.request("good.a", b"3", 60)
            await later.close()

            async def silent(_: SiteMessage) -> None:
                pass

            await one.subscribe("silent", silent)
            await one.flush(60)
            with pytest.raises(TimeoutError):
                await other.request("silent", b"", 0.05)
            assert heard.data == [b"1", b"2"]
            assert one.max_payload == 1024 * 1024
            with pytest.raises(Unavailable) as refused:
                await one.publish("good.a", b"x" * (one.max_payload + 1))
            assert refused.value.code == "message_too_large"
            assert one.connected


async def test_what_is_subscribed_to_while_the_connection_comes_about_is_heard(tmp_path: Path) -> None:
    with nats_server(tmp_path) as server:
        async with open_broker(options(server.url)) as broker:
            heard, count = Heard(), 0
            while not broker.connected:
                if count < 200:
                    await broker.subscribe(f"good.{count}", heard)
                    count += 1
                await asyncio.sleep(0.001)
            answers = [await broker.request(f"good.{number}", b"1", 60) for number in range(count)]
            assert answers == [b"heard 1"] * count


async def test_a_handler_that_fails_does_not_end_the_subscription(tmp_path: Path) -> None:
    with nats_server(tmp_path) as server:
        async with open_broker(options(server.url)) as broker:

            async def fragile(received: SiteMessage) -> None:
                if not received.data:
                    raise ValueError
                await received.reply(received.data)

            await broker.subscribe("good", fragile)
            await publish(broker, "good", b"")
            assert await broker.request("good", b"1", 60) == b"1"


async def test_a_handler_that_is_too_slow_loses_messages_and_nothing_else(tmp_path: Path) -> None:
    """What waits for it is bounded."""
    with nats_server(tmp_path) as server:
        async with open_broker(options(server.url)) as broker:
            go_on, handled = asyncio.Event(), list[bytes]()

            async def slow(received: SiteMessage) -> None:
                await go_on.wait()
                handled.append(received.data)

            await broker.subscribe("slow", slow)
            await until(lambda: broker.connected)
            for _ in range(MAX_MESSAGES + 100):
                await broker.publish("slow", b"")
            await until(lambda: broker.refused["slow_consumer"] > 0)
            go_on.set()
            await until(lambda: len(handled) >= MAX_MESSAGES)
            await broker.publish("slow", b"last")
            await until(lambda: handled[-1] == b"last")


async def test_nothing_is_sent_later(tmp_path: Path) -> None:
    """A server that dies comes again with the subscriptions, and with nothing of before."""
    with nats_server(tmp_path) as server:
        async with open_broker(options(server.url)) as one, open_broker(options(server.url)) as other:
            heard, changes = Heard(), list[str]()
            one.on_connect.append(lambda: changes.append("connected"))
            one.on_loss.append(lambda: changes.append("lost"))
            await one.subscribe("good", heard)
            await until(lambda: one.connected and other.connected)
            server.kill()
            await until(lambda: not one.connected and not other.connected)
            with pytest.raises(Unavailable) as refused:
                await other.publish("good", b"stale")
            assert refused.value.code == "broker_unavailable"
            with pytest.raises(Unavailable):
                await other.request("good", b"stale", 60)
            server.start()
            await until(lambda: one.connected and other.connected)
            assert await other.request("good", b"fresh", 60) == b"heard fresh"
            assert heard.data == [b"fresh"]
            assert changes == ["connected", "lost", "connected"]


async def test_what_waits_for_a_frozen_server_is_never_sent(tmp_path: Path) -> None:
    """A server that says nothing is given up; who waits for it hears so at once, and it never gets what waited."""
    with nats_server(tmp_path) as server:
        async with (
            open_broker(options(server.url)) as one,
            open_broker(options(server.url, check=(0.2, 1.5))) as other,
        ):
            heard = Heard()
            await one.subscribe("good", heard)
            await until(lambda: one.connected and other.connected)
            lost = asyncio.Event()
            other.on_loss.append(lost.set)
            server.freeze()
            answer = asyncio.create_task(other.request("silent", b"", 600))
            await asyncio.sleep(0)  # it is sent

            async def flood() -> None:
                while True:
                    await other.publish("good", b"x" * 100_000)

            with pytest.raises(Unavailable):
                await flood()
            with pytest.raises(TimeoutError):
                await answer
            await lost.wait()
            server.thaw()
            await until(lambda: other.connected)
            assert await other.request("good", b"fresh", 60) == b"heard fresh"
            assert set(heard.data) <= {b"x" * 100_000, b"fresh"}


async def test_a_publisher_that_waits_can_be_cancelled(tmp_path: Path) -> None:
    with nats_server(tmp_path) as server:
        async with open_broker(options(server.url)) as broker:
            await until(lambda: broker.connected)
            server.freeze()

            async def flood() -> None:
                while True:
                    await broker.publish("good", b"x" * 100_000)

            with pytest.raises(TimeoutError):
                await asyncio.wait_for(flood(), 0.5)
            server.thaw()


async def test_the_next_server_is_tried(tmp_path: Path) -> None:
    with nats_server(tmp_path) as gone, nats_server(tmp_path) as server:
        gone.kill()
        async with open_broker(options(gone.url, server.url)) as broker:
            await until(lambda: broker.connected)


async def test_users_and_what_they_may_not(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """No password in the log, no traceback; a permission that is missing is counted."""
    caplog.set_level(logging.DEBUG)
    with nats_server(tmp_path, USERS) as server:
        async with open_broker(options(server.url_of("site", "wr0ng%401"))) as stranger:
            await until(lambda: "Authorization Violation" in caplog.text)
            assert not stranger.connected
        async with open_broker(options(server.url_of("site", "s3cret%401"))) as broker:
            heard = Heard()
            await broker.subscribe("good.a", heard)
            await broker.subscribe("bad.a", heard)
            await publish(broker, "bad.b", b"1")
            await until(lambda: broker.refused["not_permitted"] == 2)
            assert await broker.request("good.a", b"1", 60) == b"heard 1"
    assert "s3cret" not in caplog.text
    assert "wr0ng" not in caplog.text
    assert "Traceback" not in caplog.text


async def test_what_is_no_credentials_file_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    jwt = "-----BEGIN NATS USER JWT-----\nabc\n------END NATS USER JWT------\n"
    account = nkeys.encode_seed(bytes(32), nkeys.PREFIX_BYTE_ACCOUNT).decode()
    wrong: tuple[str | None, ...] = (None, "", "-----BEGIN NATS USER JWT-----", "ü", jwt)
    for text in (*wrong, *(f"{jwt}-----BEGIN USER NKEY SEED-----\n{seed}\n" for seed in ("SU", "!", account))):
        file = tmp_path / "site.creds"
        file.unlink(missing_ok=True)
        if text is not None:
            file.write_text(text)
        caplog.clear()
        with nats_server(tmp_path) as server:
            async with open_broker(options(server.url, credentials=file)):
                await until(lambda: "site.creds" in caplog.text)
    assert "Traceback" not in caplog.text


TLS = 'tls {{ cert_file: "{pair.cert}", key_file: "{pair.key}" }}'


async def test_tls(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    authority = Authority(tmp_path)
    with nats_server(tmp_path, TLS.format(pair=authority.issue()), "tls") as server:
        async with open_broker(options(server.url, ca=authority.file)) as broker:
            await publish(broker, "good", b"1")
        async with open_broker(options(server.url)) as other:
            await until(lambda: "certificate verify failed" in caplog.text)
            assert not other.connected


async def test_a_password_is_not_sent_in_the_clear_where_tls_is_asked_for(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with nats_server(tmp_path, USERS, "tls") as server:  # it has no certificate
        async with open_broker(options(server.url_of("site", "s3cret%401"))) as broker:
            await until(lambda: "offers no TLS" in caplog.text)
            assert not broker.connected
        assert server.log.read_text().count("Authorization") == 0


async def test_a_server_that_talks_nonsense(caplog: pytest.LogCaptureFixture) -> None:
    """Whatever a server sends, it is one line in the log, and the next attempt comes."""
    answers = iter(
        [b"HTTP/1.1 400 Bad Request\r\n\r\n", b"INFO {\r\n", b"INFO {}\r\nPONG\r\nMSG x\r\n", b"", b"\xff" * 100_000]
    )
    done = asyncio.Event()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if (answer := next(answers, None)) is None:
            done.set()
        else:
            writer.write(answer)
        writer.close()

    listener = await asyncio.start_server(serve, "127.0.0.1", 0)
    url = f"nats://127.0.0.1:{listener.sockets[0].getsockname()[1]}"
    async with listener, open_broker(options(url)) as broker:
        await done.wait()
        assert not broker.connected
    assert "Traceback" not in caplog.text


def test_a_url_that_is_none_is_refused_at_once() -> None:
    async def main() -> None:
        async with open_broker(options("http://u:secret@h")):
            pass

    with pytest.raises(ValueError, match="a NATS URL"):
        asyncio.run(main())

"""Who the client is behind proxies, whatever the headers say."""

import asyncio
import logging
from ipaddress import ip_address

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.types import Receive, Scope, Send

from dock_gateway.http.edge.forwarded import MAX_HOPS, MAX_REPORTED, ForwardedHeaders, read_address
from dock_gateway.settings import Settings

PROXY = "10.0.0.1"
TRUSTED = ("10.0.0.0/8", "fd00::/8")
Seen = tuple[str, str]


def ask(*headers: tuple[str, str], peer: str = PROXY, trusted: tuple[str, ...] = TRUSTED, kind: str = "http") -> Seen:
    """The client's address and the scheme that the application sees."""
    return asyncio.run(pass_on(ForwardedHeaders(note, trusted), headers, peer, kind))


SEEN: list[Seen] = []


async def note(scope: Scope, _: Receive, __: Send) -> None:
    SEEN.append((scope["client"][0], scope["scheme"]))


async def pass_on(app: ForwardedHeaders, headers: tuple[tuple[str, str], ...], peer: str, kind: str = "http") -> Seen:
    encoded = [(name.lower().encode(), value.encode("latin1")) for name, value in headers]
    scope = {
        "type": kind,
        "scheme": "ws" if kind == "websocket" else "http",
        "client": (peer, 5000),
        "headers": encoded,
    }
    await app(scope, None, None)  # type: ignore[arg-type] - not used
    return SEEN.pop()


@pytest.mark.parametrize("peer", ["127.0.0.1", "::1", "192.0.2.1", "::ffff:127.0.0.1"])
@pytest.mark.parametrize("header", ["X-Forwarded-For", "Forwarded", "X-Real-IP", "X-Client-IP", "CF-Connecting-IP"])
def test_nobody_is_trusted_by_default(peer: str, header: str) -> None:
    headers = ((header, "198.51.100.9"), ("X-Forwarded-Proto", "https"))
    assert ask(*headers, peer=peer, trusted=Settings().trusted_proxies) == (peer, "http")


@pytest.mark.parametrize(
    ("lines", "client"),
    [
        (["198.51.100.9"], "198.51.100.9"),
        (["6.6.6.6, 198.51.100.9"], "198.51.100.9"),  # the first part is what the client itself has sent
        (["6.6.6.6", "198.51.100.9"], "198.51.100.9"),
        (["198.51.100.9, 10.0.0.2, 10.0.0.3"], "198.51.100.9"),  # two more proxies
        (["6.6.6.6, 198.51.100.9, 10.0.0.2"], "198.51.100.9"),
        (["10.0.0.7"], "10.0.0.7"),  # a client within the trusted network
        (["198.51.100.9:4711"], "198.51.100.9"),
        (["[2001:db8::1]:4711"], "2001:db8::1"),
        (["[2001:db8::1]"], "2001:db8::1"),
        (["2001:DB8:0::1"], "2001:db8::1"),
        (['"[2001:db8::1]:4711"'], "2001:db8::1"),
        (["fe80::1%eth0"], "fe80::1"),
        (["::ffff:198.51.100.9"], "198.51.100.9"),
        (["198.51.100.9, ::ffff:10.0.0.2"], "198.51.100.9"),
        (["198.51.100.9, fd00::2"], "198.51.100.9"),
        (["198.51.100.9,"], "198.51.100.9"),
        ([", ,198.51.100.9 , "], "198.51.100.9"),
        # The proxy does not say who it is: what stands before that is not believed.
        (["unknown"], PROXY),
        (["6.6.6.6, unknown"], PROXY),
        (["6.6.6.6, unknown, 10.0.0.2"], "10.0.0.2"),
        (["6.6.6.6, _hidden"], PROXY),
        (["6.6.6.6, 198.51.100"], PROXY),
        (["6.6.6.6, 198.51.100.9:port"], PROXY),
        (["6.6.6.6, [2001:db8::1"], PROXY),
        (["6.6.6.6, [2001:db8::1]x"], PROXY),
        (["6.6.6.6, 0x7f000001"], PROXY),
        (["6.6.6.6, robot.example"], PROXY),
        (["6.6.6.6, 198.51.100.9\xa0\xb2"], PROXY),
        ([""], PROXY),
        ([", ,"], PROXY),
        (["6.6.6.6, " * 10_000 + "198.51.100.9"], "198.51.100.9"),
        (["6.6.6.6, " + ", ".join(["10.0.0.2"] * MAX_HOPS)], "10.0.0.2"),
    ],
)
def test_the_last_address_that_is_not_a_trusted_proxy(lines: list[str], client: str) -> None:
    assert ask(*(("X-Forwarded-For", line) for line in lines))[0] == client


@given(st.lists(st.text(max_size=20).map(lambda text: text.encode("latin1", "ignore").decode("latin1")), max_size=8))
def test_what_a_client_sends_changes_nothing_of_what_its_proxy_appends(sent: list[str]) -> None:
    headers = [("X-Forwarded-For", line) for line in sent]
    assert ask(*headers, ("X-Forwarded-For", "198.51.100.9"))[0] == "198.51.100.9"
    assert ask(("X-Forwarded-For", ", ".join([*sent, "198.51.100.9"])))[0] == "198.51.100.9"
    seen, _ = ask(*headers)  # the proxy appends nothing: still an address, and never anything else
    assert ip_address(seen)


@pytest.mark.parametrize(
    ("values", "scheme"),
    [
        (["https"], "https"),
        (["HTTPS"], "https"),
        (["wss"], "https"),
        (["http"], "http"),
        (["https, http"], "http"),  # the nearest proxy has the last word
        (["https", "http"], "http"),
        (["ftp"], "http"),
        (["javascript:alert(1)"], "http"),
        ([""], "http"),
    ],
)
def test_the_scheme(values: list[str], scheme: str) -> None:
    headers = [("X-Forwarded-Proto", value) for value in values]
    assert ask(*headers)[1] == scheme
    assert ask(*headers, kind="websocket")[1] == scheme.replace("http", "ws")


def test_a_trusted_peer_may_be_an_ipv4_address_within_an_ipv6_one() -> None:
    """As on a socket that listens on `::`."""
    assert ask(("X-Forwarded-For", "198.51.100.9"), peer="::ffff:10.0.0.1")[0] == "198.51.100.9"


def test_what_is_ignored_is_said_once_for_each_address(caplog: pytest.LogCaptureFixture) -> None:
    app = ForwardedHeaders(note, ())

    async def flood() -> None:
        for _ in range(3):
            await pass_on(app, (("X-Forwarded-For", "6.6.6.6"), ("X-Forwarded-Proto", "https")), "127.0.0.1")
        await pass_on(app, (("Accept", "*/*"),), "192.0.2.7")
        for number in range(200):
            await pass_on(app, (("Forwarded", "for=6.6.6.6"),), f"192.0.2.{number}")

    with caplog.at_level(logging.WARNING):
        asyncio.run(flood())
    first, *others = (record.getMessage() for record in caplog.records)
    assert first.startswith("X-Forwarded-For, X-Forwarded-Proto from 127.0.0.1 is ignored, as DOCK_GATEWAY_TRUSTED_PR")
    assert len(others) == MAX_REPORTED - 1
    assert not any("6.6.6.6" in line for line in [first, *others])


@given(st.text(max_size=60))
def test_any_text_is_an_address_or_none(text: str) -> None:
    address = read_address(text)
    assert address is None or ip_address(str(address)) == address

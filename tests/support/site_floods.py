"""Programs that attack a site, or a hub, by the NATS server, each in a process of its own.

`python -m tests.support.site_floods NAME URL SITE INSTANCE FOLDER`: messages of one kind, `RATE` in a second, until it
is ended. The folder has the hub's key as `hub-key.json`: its id is known to all, and only that is read.
"""

import os
import socket
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import orjson

from dock_gateway.core.grant import Grant, Role
from dock_gateway.sites import subjects
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.seals import KeyAgreement, seal
from dock_gateway.sites.tunnel.frames import encode
from tests.support.processes import Process

# Messages in a second: 65,000 in 20 s.
RATE = 3_250
PIECE = 50
INBOX = "_INBOX.hub.flood"
Message = tuple[str, bytes]


def forged(site: str, instance: str, folder: Path) -> Message:
    """A stop that says what one of the hub says, signed with another key: only the signature shows it."""
    true, false = (Signer.load_or_create(folder / name) for name in ("hub-key.json", "forged.json"))
    false._header["kid"] = true._header["kid"]  # noqa: SLF001 - no signer forges by itself
    token = false.sign(site, instance, "eve", Grant(Role.OPERATOR), "POST", "/stop", time.time())
    return opening(site, instance, token)


def opening(site: str, instance: str, token: str) -> Message:
    """A message that asks to stop all robots."""
    fields = {"id": subjects.new_id(), "token": token, "kind": "http", "method": "POST", "path": "/stop"}
    return subjects.open_stream(site, instance), encode(fields)


def unsigned(site: str, instance: str, _: Path) -> Message:
    return opening(site, instance, "x" * 300)


def sealed_by_others(site: str, instance: str, folder: Path) -> Message:
    """A forged stop with a seal of another key."""
    subject, message = forged(site, instance, folder)
    return subject, seal(KeyAgreement().agree(KeyAgreement().public, site, instance), message)


def nonsense(site: str, instance: str, _: Path) -> Message:
    return subjects.open_stream(site, instance), os.urandom(700)


def frames_to_site(site: str, instance: str, _: Path) -> Message:
    return subjects.stream_to_site(site, instance, subjects.new_id()), encode({"type": "data", "n": 1}, b"x" * 500)


def frames_to_hub(site: str, _: str, __: Path) -> Message:
    return subjects.stream_to_hub(site, subjects.new_id()), encode({"type": "data", "n": 1}, b"x" * 500)


def hellos(site: str, instance: str, _: Path) -> Message:
    said = {"installation": "0" * 32, "instance": instance, "version": "0.1.0", "at": time.time()}
    return subjects.hello(site), orjson.dumps(said)


def hellos_of_nonsense(site: str, _: str, __: Path) -> Message:
    return subjects.hello(site), os.urandom(700)


# Those that a site is attacked with, with the hub's login; and those that a site attacks its hub with.
AT_SITE: dict[str, Callable[[str, str, Path], Message]] = {
    "forged stops": forged,
    "stops without a signature": unsigned,
    "stops with a forged seal": sealed_by_others,
    "nonsense": nonsense,
    "frames of no stream": frames_to_site,
}
AT_HUB: dict[str, Callable[[str, str, Path], Message]] = {
    "hellos": hellos,
    "hellos of nonsense": hellos_of_nonsense,
    "frames of no stream, to the hub": frames_to_hub,
}


def run(name: str, url: str, site: str, instance: str, folder: str) -> None:
    """Flood until this process is ended."""
    make, address = (AT_SITE | AT_HUB)[name], urlsplit(url)
    messages = [make(site, instance, Path(folder)) for _ in range(500)]
    lines = [
        b"PUB %s %s %d\r\n%s\r\n" % (subject.encode(), INBOX.encode(), len(data), data) for subject, data in messages
    ]
    pieces = [b"".join(lines[start : start + PIECE]) for start in range(0, len(lines), PIECE)]
    login = {"user": address.username, "pass": address.password, "verbose": False, "pedantic": False}
    with socket.create_connection((address.hostname, address.port or 4222)) as connection:
        connection.sendall(b"CONNECT %s\r\n" % orjson.dumps(login))
        print("flooding", flush=True)
        began = time.monotonic()
        sent = 0
        while True:
            connection.sendall(pieces[sent % len(pieces)])
            sent += 1
            time.sleep(max(0.0, began + sent * PIECE / RATE - time.monotonic()))


@contextmanager
def flooding(name: str, url: str, site: str, instance: str, folder: Path) -> Iterator[None]:
    """Flood a site, or its hub, within the block."""
    command = (sys.executable, "-m", __spec__.name, name, url, site, instance, str(folder))
    with Process(*command, env=dict(os.environ)) as process:
        process.wait_for("flooding")
        yield


if __name__ == "__main__":
    run(*sys.argv[1:])

"""The NATS subjects between sites and their hub, built and read.

`dock.hub.hello.{site}`                      a site asks whether it is welcome
`dock.site.{site}.{instance}.open`           the hub opens a stream
`dock.site.{site}.{instance}.stream.{id}`    frames of a stream, to the site
`dock.hub.stream.{site}.{id}`                frames of a stream, to the hub

A site's name is read from the subject only: NATS checks who may publish there.
"""

import re
import secrets

from dock_gateway.setting_types import SITE

# A process of a gateway, or a stream.
ID_PATTERN = r"^[0-9a-f]{16}$"
# The hub's own place among the inboxes, which no site may take.
HUB = "hub"

HELLOS = "dock.hub.hello.*"

_ID = re.compile(ID_PATTERN)


def is_site_name(name: str) -> bool:
    """Return whether a site may have that name."""
    return SITE.fullmatch(name) is not None


def new_id() -> str:
    """Return a random id, for a gateway's process or a stream."""
    return secrets.token_hex(8)


def hello(site: str) -> str:
    """Return where a site asks whether it is welcome."""
    return f"dock.hub.hello.{site}"


def open_stream(site: str, instance: str) -> str:
    """Return where the hub opens streams of a site."""
    return f"dock.site.{site}.{instance}.open"


def stream_to_site(site: str, instance: str, stream: str) -> str:
    """Return where the hub sends frames of a stream."""
    return f"dock.site.{site}.{instance}.stream.{stream}"


def stream_to_hub(site: str, stream: str) -> str:
    """Return where a site sends frames of a stream."""
    return f"dock.hub.stream.{site}.{stream}"


def streams_to_hub(site: str) -> str:
    """Return the pattern of all frames of a site: one for each site, as leaf nodes know no wildcard for the site."""
    return f"dock.hub.stream.{site}.*"


def inbox(name: str) -> str:
    """Return the prefix of the replies to a site, or to the hub (`HUB`)."""
    return f"_INBOX.{name}"


def read_hello(subject: str) -> str | None:
    """Return the site of a hello; None if the subject is another one."""
    match subject.split("."):
        case ["dock", "hub", "hello", site] if is_site_name(site):
            return site
    return None


def read_stream_to_hub(subject: str) -> tuple[str, str] | None:
    """Return site and stream of a frame to the hub; None if the subject is another one."""
    match subject.split("."):
        case ["dock", "hub", "stream", site, stream] if is_site_name(site) and _ID.fullmatch(stream):
            return site, stream
    return None


def read_stream_to_site(subject: str) -> str | None:
    """Return the stream of a frame to a site; None if the subject is another one."""
    match subject.split("."):
        case ["dock", "site", _, _, "stream", stream] if _ID.fullmatch(stream):
            return stream
    return None

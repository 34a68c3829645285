"""The types of settings: how a value is read, and what it may be. A refusal is a sentence for the user."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from ipaddress import ip_address, ip_network
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

from pydantic import AfterValidator, BeforeValidator, Field, SecretStr
from pydantic_settings import NoDecode

LOOPBACK_HOSTS = frozenset({"127.0.0.1", "::1", "localhost"})

# What ROS accepts as the name of a node, of a topic or an action, as a namespace, and as the type of an action.
ROS_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Maximum number of characters of an absolute name on the ROS graph.
LONGEST_NAME = 255
TOPIC = re.compile(rf"/?{ROS_TOKEN.pattern}(?:/{ROS_TOKEN.pattern})*")
NAMESPACE = re.compile(rf"/?|{TOPIC.pattern}/?")
# A namespace in which `*` stands for any text.
ROBOTS = re.compile(r"/?|/?[A-Za-z0-9_*]+(?:/[A-Za-z0-9_*]+)*/?")
# A pattern of names, in which `*` stands for any text. No part between two slashes is empty.
PATTERN = re.compile(r"(?!.*//)(?:/[A-Za-z0-9_/*]*|\*[A-Za-z0-9_/*]+)")
# A site's name: a ROS name in lower case, as robots have it in front at the hub, and a part of subjects on the broker.
SITE = re.compile(r"(?!hub$)[a-z][a-z0-9_]{0,39}")
ACTION_TYPE = re.compile(rf"{ROS_TOKEN.pattern}/action/{ROS_TOKEN.pattern}")

# A host with or without a port, and an origin.
HOST = re.compile(r"(?P<host>[a-z0-9_.-]+|\[[0-9a-f:.]+\])(?::(?P<port>[0-9]{1,5}))?")
ORIGIN = re.compile(rf"(?P<scheme>(?!wss?:)[a-z][a-z0-9+.-]*)://{HOST.pattern}/?")
PORTS = {"http": "80", "https": "443"}


@dataclass(frozen=True)
class ListensOn:
    """Marks a setting that is a port to listen on.

    Attributes:
        path: Where WebSockets of `/` lead that come in on it; None: it is the port of all paths.
    """

    path: str | None = None


@dataclass(frozen=True)
class Tuning:
    """Marks a setting that tests and experts change. It is in no help, and may change or go with any version."""


TUNING = Tuning()


def _split(value: object) -> object:
    """Return the parts of a setting that are separated by commas."""
    parts = value.split(",") if isinstance(value, str) else value
    if not isinstance(parts, list | tuple):
        return value
    stripped = (part.strip() if isinstance(part, str) else part for part in parts)
    return tuple(part for part in stripped if part)


def _matching(pattern: re.Pattern[str], what: str, *, or_empty: bool = False) -> Callable[[str], str]:
    """Return a validator that refuses a text that does not match."""

    def check(value: str) -> str:
        if not (pattern.fullmatch(value) or (or_empty and not value)):
            raise ValueError(f"{value[:100]!r} is not {what}")
        return value

    return check


def _each(check: Callable[[str], str]) -> Callable[[tuple[str, ...]], tuple[str, ...]]:
    return lambda parts: tuple(map(check, parts))


def _check_proxies(parts: tuple[str, ...]) -> tuple[str, ...]:
    for part in parts:
        ip_network(part)
    return parts


def _origin(value: str) -> str:
    """Return an origin as browsers send it: without a slash at the end and the scheme's own port, in lower case."""
    if value in ("*", "null"):
        return value
    match = ORIGIN.fullmatch(value.lower())
    if match is None:
        scheme, host = _split_address(value)
        wanted = [{"ws": "http", "wss": "https"}.get(scheme, scheme)] if scheme else ["http", "https"]
        instead = " or ".join(f"{each}://{host}" for each in wanted if ORIGIN.fullmatch(f"{each}://{host}"))
        raise ValueError(
            f"{value[:100]!r} is not an origin, which is a scheme, a host and a port (if it is not the scheme's own): "
            f"write {instead or 'it like http://10.0.0.5:3000'}"
        )
    scheme, host, port = match["scheme"], match["host"], match["port"]
    return f"{scheme}://{host}" if port in (None, PORTS.get(scheme)) else f"{scheme}://{host}:{port}"


def _host_name(value: str) -> str:
    """Return a host name: of an address such as `http://robot.local:8000/`, the name in it."""
    if value == "*":
        return value
    with suppress(ValueError):
        return str(ip_address(value))
    match = HOST.fullmatch(_split_address(value)[1])
    if match is None:
        raise ValueError(f"{value[:100]!r} is not a host name such as robot.local; * allows any")
    return match["host"].strip("[]")


def _split_address(value: str) -> tuple[str, str]:
    """Return the scheme of an address, which may be empty, and its host with the port."""
    scheme, _, rest = value.lower().rpartition("://")
    return scheme, re.split(r"[/?#]", rest)[0]


def is_safe_broker(url: str) -> bool:
    """Return whether a broker of `Brokers` is asked over TLS, or on this machine."""
    address = urlsplit(url)
    return address.scheme == "tls" or address.hostname in LOOPBACK_HOSTS


def _check_brokers(parts: tuple[str, ...]) -> tuple[str, ...]:
    for part in parts:
        try:
            address = urlsplit(part)
            _ = address.port
        except ValueError:
            address = urlsplit("")
        wrong = address.path.strip("/") or address.query or address.fragment or not part.isprintable()
        if address.scheme not in ("nats", "tls") or not address.hostname or wrong:
            # Not the part itself: a password may be in it.
            raise ValueError(
                "write the addresses of NATS servers like tls://nats.example.com:4222, with commas between"
            )
    return parts


Seconds = Annotated[float, Field(gt=0, le=3600)]
# 1000 years. The beginning of a much longer time would lie before the first date that there is.
Days = Annotated[float, Field(ge=1, le=365_000)]
Megabytes = Annotated[int, Field(ge=1, le=1_000_000_000)]

_EMPTY_AS_NONE = BeforeValidator(lambda value: value or None)
OptionalText = Annotated[str | None, _EMPTY_AS_NONE]
OptionalFile = Annotated[Path | None, _EMPTY_AS_NONE]
OptionalSecret = Annotated[SecretStr | None, _EMPTY_AS_NONE]

_TOPIC = "a ROS name such as dock or /hall/dock: letters, digits, _ and /"
Topic = Annotated[str, AfterValidator(_matching(TOPIC, _TOPIC))]
OptionalTopic = Annotated[str, AfterValidator(_matching(TOPIC, _TOPIC, or_empty=True))]
NodeName = Annotated[
    str, AfterValidator(_matching(ROS_TOKEN, "a ROS node name: letters, digits and _, not starting with a digit"))
]
Namespace = Annotated[
    str, AfterValidator(_matching(NAMESPACE, "a ROS namespace such as /robot1: letters, digits, _ and /"))
]
ActionType = Annotated[
    str,
    AfterValidator(_matching(ACTION_TYPE, "an action type such as some_package/action/Dock", or_empty=True)),
]

# Separated by commas.
Texts = Annotated[tuple[str, ...], NoDecode, BeforeValidator(_split)]
LowerTexts = Annotated[Texts, AfterValidator(_each(str.lower))]
Origins = Annotated[Texts, AfterValidator(_each(_origin))]
HostNames = Annotated[Texts, AfterValidator(_each(_host_name))]
ExtensionNames = Annotated[
    Texts, AfterValidator(_each(_matching(re.compile("[a-z][a-z0-9_]{0,59}"), "the name of an extension")))
]
Networks = Annotated[LowerTexts, AfterValidator(_check_proxies)]
Topics = Annotated[Texts, AfterValidator(_each(_matching(TOPIC, _TOPIC)))]
Robots = Annotated[
    Texts,
    AfterValidator(_each(_matching(ROBOTS, "a namespace such as /robot1 or /hall_a/*, and not * for all"))),
]
Patterns = Annotated[
    Texts,
    AfterValidator(_each(_matching(PATTERN, "a name such as /battery_status, or a pattern such as /robot1/*"))),
]
RobotPatterns = Annotated[
    Texts,
    AfterValidator(_each(_matching(PATTERN, "a namespace such as /robot1, or a pattern such as /hall_a/*"))),
]
SiteName = Annotated[
    str,
    AfterValidator(
        _matching(SITE, "a name such as berlin: up to 40 of a-z, 0-9 and _, a letter first, not hub", or_empty=True)
    ),
]
Brokers = Annotated[Texts, AfterValidator(_check_brokers)]

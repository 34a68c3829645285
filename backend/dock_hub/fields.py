"""Fields of what a site sends, each checked. A reader gets the site and a value, and returns what the hub has of it.

Each raises `ForeignDocumentError` if the value is something else.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import orjson

from dock_gateway.setting_types import LONGEST_NAME, ROS_TOKEN
from dock_gateway.sites.names import to_hub

Document = dict[str, Any]
Reader = Callable[[str, Any], Any]
T = TypeVar("T")

ROS_NAME = re.compile(f"/(?:{ROS_TOKEN.pattern}(?:/{ROS_TOKEN.pattern})*)?")
MAX_TEXT = 8000  # characters
# Entries of a list, and bytes of a robot, an alert or an approval.
MAX_ENTRIES, MAX_DOCUMENT = 2000, 32 * 1024


class ForeignDocumentError(ValueError):
    """A site has sent what is not a document of a gateway. The sentence says what is wrong with it."""


def as_is(_: str, value: Any) -> Any:
    """Return the value as it is."""
    return value


def nothing(_: str, __: Any) -> None:
    """Return None: it makes no sense at the hub."""


def no(_: str, __: Any) -> bool:
    """Return False, whatever the site says."""
    return False


def name(site: str, value: Any) -> str:
    """Return a name of the hub: of a robot, an action or a topic."""
    if not isinstance(value, str) or len(value) > LONGEST_NAME or not ROS_NAME.fullmatch(value):
        raise ForeignDocumentError(f"{value!r:.60} is not a ROS name")
    return to_hub(site, value)


def whole_site(site: str, value: Any) -> str:
    """Return the name of a robot; of the site, if it is not about one robot."""
    return to_hub(site, "/") if value is None else name(site, value)


def flag(_: str, value: Any) -> bool:
    """Return true or false."""
    if not isinstance(value, bool):
        raise ForeignDocumentError(f"{value!r:.60} is neither true nor false")
    return value


def text(_: str, value: Any) -> str:
    """Return a text."""
    if not isinstance(value, str) or len(value) > MAX_TEXT or "\0" in value:  # which databases do not accept
        raise ForeignDocumentError(f"{value!r:.60} is not a text")
    return value


def site_id(site: str, value: Any) -> str:
    """Return the id of an alert or an approval: those of two sites may be the same."""
    return f"{site}.{text(site, value)}"


def one_of(*values: str) -> Reader:
    """Return the reader of one of these texts."""

    def read(_: str, value: Any) -> Any:
        if value not in values:
            raise ForeignDocumentError(f"{value!r:.60} is none of {', '.join(values)}")
        return value

    return read


def shape(fields: Mapping[str, Reader], *, site_field: bool = False) -> Callable[[str, Any], Document]:
    """Return the reader of an object with these fields; with `site_field`, also with the site, and not too large."""

    def read(site: str, value: Any) -> Document:
        if not isinstance(value, dict):
            raise ForeignDocumentError(f"{value!r:.60} is not an object")
        document = {name: field(site, value.get(name)) for name, field in fields.items()}
        return _sized(document | {"site": site}) if site_field else document

    return read


def _sized(document: Document) -> Document:
    """Return a document, unless it is too large or too deep to be shown together with others."""
    try:
        size = len(orjson.dumps([[[[document]]]]))
    except orjson.JSONEncodeError as error:
        raise ForeignDocumentError(f"a document cannot be written as JSON: {error}") from None
    if size > MAX_DOCUMENT:
        raise ForeignDocumentError(f"a document has {size} bytes, and at most {MAX_DOCUMENT} are read")
    return document


def maybe(reader: Reader) -> Reader:
    """Return the reader of what may be null."""
    return lambda site, value: None if value is None else reader(site, value)


def each(reader: Callable[[str, Any], T]) -> Callable[[str, Any], list[T]]:
    """Return the reader of a list."""

    def read(site: str, value: Any) -> list[T]:
        if not isinstance(value, list):
            raise ForeignDocumentError(f"{value!r:.60} is not a list")
        if len(value) > MAX_ENTRIES:
            raise ForeignDocumentError(f"a list has {len(value)} entries, and at most {MAX_ENTRIES} are read")
        return [reader(site, item) for item in value]

    return read


def count(_: str, value: Any) -> int:
    """Return a number of things."""
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**31:
        raise ForeignDocumentError(f"{value!r:.60} is not a count")
    return value

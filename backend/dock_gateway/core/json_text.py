"""Reads JSON from clients, and says what is wrong with it."""

import json
import math
import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from http import HTTPStatus
from typing import Any

import orjson

from dock_gateway.core.errors import MalformedRequest

# What Python and others write for numbers that JSON does not have.
CONSTANT = re.compile(r"nan\b|inf(inity)?\b", re.IGNORECASE)
# Objects and arrays in a text: a million bytes of them would take 0.2 s of the event loop.
MAX_NESTED = 20_000
# Bytes of a message with such numbers: reading them takes ten times as long as reading JSON.
MAX_WITH_CONSTANTS = 250_000


class Infinite(float):
    """±Infinity, as a client of rosbridge may write it. Everywhere else an infinite number is refused."""


def decode_json(text: bytes | str, what: str, *, constants: bool = False) -> Any:
    """Decode JSON from a client. A byte order mark is ignored, as RFC 8259, 8.1, allows: editors on Windows write one.

    Args:
        text: The JSON text.
        what: What it is, for the error.
        constants: Whether `NaN`, `Infinity` and `-Infinity` are numbers, as in Python's `json`; the last two become
            `Infinite`.

    Raises:
        MalformedRequest: It is not JSON, or has more objects and arrays than are read at once (`body_too_large`).
    """
    raw = text.encode() if isinstance(text, str) else text
    if raw.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        raise MalformedRequest(f"{what} is UTF-16: send it as UTF-8")
    raw = raw.removeprefix(BOM_UTF8)
    if len(raw) > MAX_NESTED and raw.count(b"{") + raw.count(b"[") > MAX_NESTED:
        raise MalformedRequest(
            f"{what} has more than {MAX_NESTED:,} objects and arrays",
            code="body_too_large",
            status=HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
        )
    try:
        return orjson.loads(raw)
    except orjson.JSONDecodeError as error:
        if CONSTANT.match(error.doc, error.pos) is None:
            raise MalformedRequest(f"{what} is not JSON: {error}") from None
        if not constants:
            raise MalformedRequest(
                f"{what} is not JSON, which has neither NaN nor Infinity: send null instead of NaN; infinite numbers "
                f"are not accepted here ({error})"
            ) from None
    return _decode_with_constants(raw, what)


def _decode_with_constants(raw: bytes, what: str) -> Any:
    if len(raw) > MAX_WITH_CONSTANTS:
        raise MalformedRequest(
            f"{what} is longer than {MAX_WITH_CONSTANTS} bytes: NaN and Infinity are accepted in shorter ones only; "
            "send null instead of NaN"
        )
    try:
        decoded = json.loads(raw.decode(), parse_constant=_constant)
        orjson.dumps(decoded, default=float)  # refuses values that orjson does not read
    except (ValueError, TypeError, RecursionError) as error:
        raise MalformedRequest(f"{what} is not JSON: {str(error)[:200]}") from None
    return decoded


def _constant(name: str) -> float:
    return math.nan if name == "NaN" else Infinite(name)

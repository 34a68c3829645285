"""A cursor: the place of an entry in a list that is newest first, which clients send back as text."""

import re
from base64 import b64decode, urlsafe_b64encode
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from typing import NamedTuple

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)
_FORM = re.compile(r"([0-9]{1,17}) ([\x21-\x7e]{1,100})")


class Cursor(NamedTuple):
    """A time and an id, by which a list is sorted. It does not need the entry, which may have been deleted.

    Attributes:
        time: When the entry was made.
        id: Its id.
    """

    time: datetime
    id: str

    def encode(self) -> str:
        """Return it as text, which `read_cursor` reads."""
        text = f"{(self.time - _EPOCH) // _MICROSECOND} {self.id}"
        return urlsafe_b64encode(text.encode()).decode().rstrip("=")


def newest(entries: Iterable[Cursor], limit: int, end: Cursor | None) -> tuple[list[Cursor], Cursor | None]:
    """Return a page of a list that is in memory, newest first, and where it ends; None if it is the last one.

    Args:
        entries: The places of all entries.
        limit: The length of a page.
        end: Where the page before ended; None for the first one.
    """
    found = sorted((each for each in entries if end is None or each < end), reverse=True)
    return found[:limit], found[limit - 1] if len(found) > limit else None


def read_cursor(text: str) -> Cursor:
    """Return the cursor that a text is.

    Raises:
        ValueError: It is none; the message says what is expected.
    """
    try:
        found = _FORM.fullmatch(b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True).decode())
        if found is not None:
            return Cursor(_EPOCH + int(found[1]) * _MICROSECOND, found[2])
    except (ValueError, OverflowError):
        pass
    raise ValueError("`next_cursor` of an earlier answer")

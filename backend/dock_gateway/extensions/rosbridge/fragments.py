"""Messages in pieces: those that a client sends, and those that are too long for it."""

import itertools
from collections.abc import Iterator
from http import HTTPStatus
from typing import Annotated

from pydantic import Field

from dock_gateway.core.errors import FieldError, InvalidField, MalformedRequest
from dock_gateway.extensions.rosbridge.protocol import Identity, RosbridgeOperation, fragment

# Messages of a connection that may be incomplete at a time, and the pieces of each, as well as of one that it is sent.
MAX_MESSAGES, MAX_PIECES = 8, 10_000


class Fragment(RosbridgeOperation):
    """A piece of a message."""

    data: str
    num: Annotated[int, Field(ge=0)]
    total: Annotated[int, Field(ge=1, le=MAX_PIECES)]


class Fragments:
    """The incomplete messages of one client.

    Args:
        max_size: Maximum number of characters of all of them.
    """

    def __init__(self, max_size: int) -> None:
        self._max_size = max_size
        self._size = 0
        self._pieces: dict[Identity, dict[int, str]] = {}

    def add(self, piece: Fragment, identity: Identity) -> str | None:
        """Add a piece. Return the message, if it is complete. Old incomplete ones make room: a stop may be the newest.

        Raises:
            InvalidField: It is no piece of a message.
            MalformedRequest: The message is too large (`body_too_large`); it is forgotten.
        """
        if identity is None or piece.num >= piece.total:
            raise InvalidField([FieldError("", "an id, and a num that is less than total", "got something else")])
        pieces = self._pieces.pop(identity, {})
        self._size += len(piece.data) - len(pieces.get(piece.num, ""))
        pieces[piece.num] = piece.data
        self._pieces[identity] = pieces  # the newest is last
        while len(self._pieces) > 1 and (len(self._pieces) > MAX_MESSAGES or self._size > self._max_size):
            self._forget(next(iter(self._pieces)))
        if self._size > self._max_size:
            self._forget(identity)
            detail = f"messages in pieces exceed {self._max_size} characters"
            raise MalformedRequest(detail, code="body_too_large", status=HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        if len(pieces) < piece.total:
            return None
        self._forget(identity)
        return "".join(text for _, text in sorted(pieces.items()))

    def _forget(self, identity: Identity) -> None:
        self._size -= sum(map(len, self._pieces.pop(identity).values()))


_numbers = itertools.count(1)


def split(message: bytes, size: int | None) -> Iterator[bytes]:
    """Yield a message as it is, or in pieces of this many characters; of more, if there were more than `MAX_PIECES`."""
    if size is None or len(message) <= size:
        yield message
        return
    text, identity = message.decode(), f"fragment:{next(_numbers)}"
    size = max(size, -(-len(text) // MAX_PIECES))
    total = -(-len(text) // size)
    for number in range(total):
        yield fragment(text[number * size : (number + 1) * size], number, total, identity)

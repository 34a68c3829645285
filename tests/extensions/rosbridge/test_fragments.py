"""A message in pieces is whole again when they are put together, and has not more of them than a client can be sent."""

import orjson
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.extensions.rosbridge import fragments
from dock_gateway.extensions.rosbridge.fragments import MAX_PIECES, split


def pieces_of(message: bytes, size: int | None) -> list[str]:
    found = [orjson.loads(piece) for piece in split(message, size)]
    assert [piece["num"] for piece in found] == list(range(len(found)))
    assert {(piece["op"], piece["total"]) for piece in found} == {("fragment", len(found))}
    assert len({piece["id"] for piece in found}) == 1
    return [piece["data"] for piece in found]


@given(st.text(st.characters(codec="utf-8"), min_size=200, max_size=2_000), st.integers(1, 150))
def test_pieces_are_a_message(text: str, size: int) -> None:
    pieces = pieces_of(text.encode(), size)
    assert "".join(pieces) == text
    assert len(pieces) <= MAX_PIECES
    assert max(map(len, pieces)) == size


def test_a_message_has_a_limit_on_its_pieces_which_are_larger_then() -> None:
    text = "cell" * 1_000_000
    pieces = pieces_of(text.encode(), 100)
    assert "".join(pieces) == text
    assert len(pieces) == fragments.MAX_PIECES
    assert {len(piece) for piece in pieces} == {400}


def test_a_short_message_is_whole() -> None:
    assert [*split(b"short", 100)] == [*split(b"short", None)] == [b"short"]

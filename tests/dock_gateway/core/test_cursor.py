"""A cursor is a text that says where a page ends, without the entry that was there."""

from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.cursor import Cursor, newest, read_cursor

TIMES = st.datetimes(datetime(1970, 1, 1), datetime(2900, 1, 1), timezones=st.just(UTC))  # noqa: DTZ001


@given(TIMES, st.uuids())
def test_a_cursor_is_read_as_it_was_written(time: datetime, identity: object) -> None:
    cursor = Cursor(time, str(identity))
    assert read_cursor(cursor.encode()) == cursor


@given(st.lists(st.builds(Cursor, TIMES, st.sampled_from("abc")), unique=True, max_size=9), st.integers(1, 4))
def test_pages_have_each_entry_once_and_newest_first(entries: list[Cursor], limit: int) -> None:
    found, end = newest(entries, limit, None)
    while end is not None:
        assert len(found) % limit == 0
        page, end = newest(entries, limit, read_cursor(end.encode()))
        assert page
        found += page
    assert found == sorted(entries, reverse=True)


@pytest.mark.parametrize("text", ["", "zzz", "3f0c7b2e-0000-4000-8000-000000000000", "é"])
def test_what_is_none_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="of an earlier answer"):
        read_cursor(text)


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        assert read_cursor(text).id
    except ValueError as error:
        assert "of an earlier answer" in str(error)  # noqa: PT017

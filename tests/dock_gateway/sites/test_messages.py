"""Hellos and their answers are read with care: they come from other machines."""

import json
from typing import Any
from uuid import uuid4

import pytest

from dock_gateway.sites.messages import Hello, Malformed, Refusal, Welcome, compatible, read, read_answer
from dock_gateway.sites.subjects import new_id

HELLO = {"installation": str(uuid4()), "instance": new_id(), "version": "0.7.1", "at": 1.5}


def test_a_message_is_read_as_it_was_written() -> None:
    hello = Hello(**HELLO, leaving=True, name_of_machine="edge-1")
    assert read(Hello, hello.encode()) == hello
    assert read_answer(Welcome(hub_version="0.8.0", at=2.0).encode()) == Welcome(hub_version="0.8.0", at=2.0)
    refusal = Refusal(code="site_name_taken", detail="another installation has the name")
    assert read_answer(refusal.encode()) == refusal


def test_what_another_release_says_more_is_left_out() -> None:
    assert read(Hello, json.dumps(HELLO | {"more": 1}).encode()) == Hello(**HELLO)


@pytest.mark.parametrize(
    "changes",
    [
        {"installation": "x"}, {"installation": None}, {"instance": "berlin"}, {"instance": "A" * 16}, {"version": ""},
        {"version": "1" * 65}, {"at": "NaN"}, {"at": None}, {"at": 1e999}, {"leaving": "perhaps"},
        {"name_of_machine": "x" * 254},
    ],
)  # fmt: skip
def test_a_field_that_is_not_valid_is_named(changes: dict[str, Any]) -> None:
    with pytest.raises(Malformed, match=next(iter(changes))) as refused:
        read(Hello, json.dumps(HELLO | changes).encode())
    assert refused.value.reason == "malformed"


@pytest.mark.parametrize("data", [b"", b"\xff", b"[]", b"null", b"{", b"[" * 8000])
def test_what_is_no_message_is_refused(data: bytes) -> None:
    with pytest.raises(Malformed):
        read(Hello, data)
    with pytest.raises(Malformed):
        read_answer(data)


def test_a_message_has_a_limit() -> None:
    with pytest.raises(Malformed) as refused:
        read(Hello, json.dumps(HELLO | {"more": "x" * 9000}).encode())
    assert refused.value.reason == "too_large"


@pytest.mark.parametrize(
    ("one", "other", "together"),
    [
        ("0.7.0", "0.7.9", True), ("0.7.0", "0.8.3", True), ("0.7.0", "0.9.0", False), ("0.7", "0.8.0.dev1+x", True),
        ("1.0.0", "0.9.0", False), ("1.2.0", "2.2.0", False), ("0.7.0", "seven", False), ("", "", False),
    ],
)  # fmt: skip
def test_releases_that_work_together(one: str, other: str, *, together: bool) -> None:
    assert compatible(one, other) is together
    assert compatible(other, one) is together

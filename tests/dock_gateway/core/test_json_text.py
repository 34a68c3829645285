"""JSON from clients: what is read, and what is refused with which sentence."""

import json
import math
import time
from typing import Any

import orjson
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from dock_gateway.core.errors import MalformedRequest
from dock_gateway.core.json_text import MAX_WITH_CONSTANTS, Infinite, decode_json

WORDS = st.sampled_from(["NaN", "Infinity", "-Infinity", '"NaN"', "\\NaN", "[NaN]", ": NaN,", "é NaN", "\\", '"'])
TEXTS = st.text(max_size=8) | WORDS
NUMBERS = st.floats() | st.integers(-(2**63), 2**64 - 1)
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | TEXTS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4),
    max_leaves=12,
)


def refusal(text: bytes | str, *, constants: bool = False) -> str:
    with pytest.raises(MalformedRequest) as refused:
        decode_json(text, "the body", constants=constants)
    assert (refused.value.status, refused.value.code) == (400, "malformed_json")
    return refused.value.detail


def as_python_writes_it(value: Any, **style: Any) -> str:
    text = json.dumps(value, **style)
    try:
        text.encode()
    except UnicodeEncodeError:
        assume(False)
    return text


def same(one: Any, other: Any) -> bool:
    """Whether two values are equal, also where NaN is in them."""
    return repr(one) == repr(other)


@given(VALUES, st.booleans(), st.sampled_from([None, 2]))
@example({"NaN": ["NaN", math.nan, "\\", -math.inf]}, True, None)
@example({'"': math.inf, "x": '", NaN'}, False, None)
def test_what_python_writes_is_read_as_it_was(value: Any, ascii_only: bool, indent: int | None) -> None:
    """Inside strings nothing is a number, whatever stands there."""
    text = as_python_writes_it(value, ensure_ascii=ascii_only, indent=indent)
    read = decode_json(text, "the body", constants=True)
    assert same(read, json.loads(text))
    assert same(decode_json(text.encode(), "the body", constants=True), read)
    try:
        plain = json.dumps(value, allow_nan=False, ensure_ascii=ascii_only)
    except ValueError:
        assert "send null instead of NaN" in refusal(text)
    else:
        assert same(decode_json(text, "the body"), orjson.loads(plain))


def test_infinite_numbers_are_marked() -> None:
    """A reader that does not know them refuses them, as it does infinite numbers of any other origin."""
    read = decode_json('{"a": [Infinity, -Infinity, NaN, 1.5]}', "it", constants=True)["a"]
    assert [type(number) for number in read] == [Infinite, Infinite, float, float]
    assert read[:2] == [math.inf, -math.inf]


@pytest.mark.parametrize("text", ["NaN", "[1, NaN]", '{"a": -Infinity}', '{"a":\n {"b": Infinity}}', "nan", "[inf]"])
def test_the_refusal_says_what_to_send(text: str) -> None:
    detail = refusal(text)
    assert "neither NaN nor Infinity" in detail
    assert "null" in detail
    assert "infinite numbers are not accepted" in detail


@pytest.mark.parametrize("constants", [False, True])
@pytest.mark.parametrize(
    "text",
    ["", "{", "[1,]", "[nano]", "[infinite]", "{'a': NaN}", "[1e400]", '"\\ud800"', "[NaN", "[NaN, nan]"],
)
def test_what_is_not_json(text: str | bytes, constants: bool) -> None:
    assert "is not JSON" in refusal(text, constants=constants)


@pytest.mark.parametrize(
    "text",
    ['[NaN, "\\ud800"]', '{"\\udfff": NaN}', f"[NaN, {'1' * 5000}]", "[NaN, " + "[" * 5_000],
)
def test_only_what_is_json_but_for_the_constants(text: str) -> None:
    assert "is not JSON" in refusal(text, constants=True)
    assert "is not JSON" in refusal(text + "]" * 5001, constants=True)


def test_a_message_with_constants_is_short_enough_to_be_read_on_the_loop() -> None:
    """Ten thousand readings, of which many are NaN, are accepted; a megabyte of them is refused without being read."""
    scan = json.dumps({"ranges": [math.nan if index % 3 else 1.2345678901234567 for index in range(10_000)]})
    assert len(decode_json(scan, "it", constants=True)["ranges"]) == 10_000
    for hostile, reason in (
        ("[" + "NaN," * 250_000 + "1]", f"longer than {MAX_WITH_CONSTANTS}"),
        ("[NaN" + ",[" * 300_000, "20,000 objects and arrays"),
        ("[NaN," + '{"a":1},' * 120_000 + "1]", "20,000 objects and arrays"),
    ):
        began = time.process_time()
        with pytest.raises(MalformedRequest, match=reason):
            decode_json(hostile, "it", constants=True)
        assert time.process_time() - began < 0.02

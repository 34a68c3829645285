"""The body of a rule is what its schema says, and what is wrong in it is said by field, in our words."""

from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.errors import InvalidField
from dock_gateway.extensions.automation.rule import RuleBody
from dock_gateway.http.bodies import MAX_ERRORS, body_schema, read_model
from tests.support.bodies import expect_refused

NAMESPACE = "a ROS namespace such as /robot1, of up to 255 characters"
RULE: dict[str, Any] = {"name": "a", "robots": {"all": True}, "battery": {"below": 0.2, "idle_s": 60}}
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False) | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from([*RULE, "below", "all", "x"]), inner),
    max_leaves=9,
)


def errors(value: object) -> list[tuple[str, str, str]]:
    with pytest.raises(InvalidField) as refused:
        read_model(RuleBody, value)
    return [(each["path"], each["expected"], each["detail"]) for each in refused.value.extra["errors"]]


@pytest.mark.parametrize(
    ("value", "error"),
    [
        ({**RULE, "when": 1}, ("when", "one of name, mode, robots, battery, schedule, by", "got an unknown field")),
        (
            {**RULE, "battery": {**RULE["battery"], "idle": 1}},
            ("battery.idle", "one of below, idle_s", "got an unknown field"),
        ),
        ({**RULE, "robots": {"al": True}}, ("robots.al", "one of all, names, groups", "got an unknown field")),
        ({**RULE, "battery": {"below": 0.2}}, ("battery.idle_s", "a value", "it is missing")),
        ({**RULE, "battery": {"below": 2, "idle_s": 60}}, ("battery.below", "less than or equal to 1", "got 2")),
        ({**RULE, "name": "a" * 61}, ("name", "1 to 60 characters, in one line", f"got '{'a' * 39}")),
        ({**RULE, "robots": {"names": ["/a", "b c"]}}, ("robots.names.1", NAMESPACE, "got 'b c'")),
        ({**RULE, "battery": None}, ("battery", "one condition, `battery` or `schedule`", "got neither")),
    ],
)
def test_each_error_says_where_and_what_is_expected(value: object, error: tuple[str, str, str]) -> None:
    assert errors(value) == [error]


def test_every_wrong_field_is_named_but_not_without_end() -> None:
    assert [path for path, *_ in errors({})] == ["name", "robots"]
    assert len(errors({**RULE, "robots": {"names": [1] * 400}})) == MAX_ERRORS


def test_what_the_schema_does_not_allow_is_refused_where_it_is_wrong() -> None:
    expect_refused(RuleBody)


@given(JSON)
def test_whatever_is_sent_is_read_or_refused(value: object) -> None:
    with suppress(InvalidField):
        read_model(RuleBody, value)


@given(st.fixed_dictionaries({}, optional=dict.fromkeys(RULE, JSON)).map(lambda fields: RULE | fields))
def test_what_is_read_is_what_was_sent(value: dict[str, Any]) -> None:
    """No text becomes a number, no number a flag."""
    try:
        body = read_model(RuleBody, value)
    except InvalidField:
        return
    assert body.name == value["name"].strip()
    assert body.robots.all is value["robots"].get("all", False)
    assert type(value["battery"]["below"]) in (int, float)


def test_a_schema_has_no_references() -> None:
    assert "$" not in str({**body_schema(RuleBody), "properties": body_schema(RuleBody)["properties"].keys()})
    robots = body_schema(RuleBody)["properties"]["robots"]
    assert set(robots["properties"]) == {"all", "names", "groups"}

"""A body is what its schema says, and what is wrong in it is said by field, in our words."""

from collections.abc import Iterator
from contextlib import suppress
from copy import deepcopy
from typing import Any

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from pydantic import BaseModel

from dock_gateway.access.schema import PasswordBody, TokenBody, UserBody
from dock_gateway.core.errors import InvalidField
from dock_gateway.extensions.agents.schema import Nothing
from dock_gateway.extensions.automation.rule import RuleBody
from dock_gateway.extensions.webhooks.webhook import WebhookBody
from dock_gateway.fleet.schema import AcknowledgementBody, Label
from dock_gateway.goals.schema import NoteBody, TagsBody
from dock_gateway.http.bodies import MAX_ERRORS, body_schema, read_fields, read_model
from dock_gateway.robots.schema import FaultBody, PlaceBody
from dock_gateway.streams.command_schema import SendGoalCommand, SubscribeCommand

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


def test_a_body_without_fields_takes_none() -> None:
    with pytest.raises(InvalidField) as refused:
        read_model(Nothing, {"x": 1})
    assert refused.value.extra["errors"] == [{"path": "x", "expected": "no field", "detail": "got an unknown field"}]


def test_every_wrong_field_is_named_but_not_without_end() -> None:
    assert [path for path, *_ in errors({})] == ["name", "robots"]
    assert len(errors({**RULE, "robots": {"names": [1] * 400}})) == MAX_ERRORS


# Of these, the schema has no example.
EXAMPLES: dict[type[BaseModel], dict[str, Any]] = {
    PasswordBody: {"old": "correct horse", "new": "another horse"},
    AcknowledgementBody: {"by": "Ada"},
    PlaceBody: {"x": 1.0, "y": 0.0, "theta": 0.5},
    FaultBody: {"active": True},
}
BODIES = [*EXAMPLES, Label, NoteBody, RuleBody, TagsBody, TokenBody, UserBody, WebhookBody]
# Of every type, and texts that a pattern may forbid.
VALUES: list[Any] = [
    None,
    True,
    1,
    1.5,
    "",
    [],
    {},
    " \t",
    "a\nb",
    "a\0",
    "a\u202eb",
    "a\u007f",
    "robot1",
    "/a b",
    "/a//b",
]
Path = tuple[str | int, ...]


def outside(schema: dict[str, Any], value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield values that the schema may not allow, with their paths below a value that it allows."""
    yield from ((path, other) for other in VALUES)
    for option in schema.get("anyOf", [schema]):
        for limit, step in (("minimum", -1), ("exclusiveMinimum", 0), ("maximum", 1)):
            yield from [(path, option[limit] + step)] if limit in option else []
        for limit, step in (("minLength", -1), ("maxLength", 1)):
            yield from [(path, "a" * (option[limit] + step))] if limit in option else []
        if isinstance(value, list) and value:
            yield from [(path, value * (option["maxItems"] + 1))] if "maxItems" in option else []
            yield from outside(option["items"], value[0], (*path, 0))
        if isinstance(value, dict) and "properties" in option:
            yield path, value | {"unknown": 1}
            for name, inner in option["properties"].items():
                yield path, {key: other for key, other in value.items() if key != name}
                if value.get(name) is not None:
                    yield from outside(inner, value[name], (*path, name))


def changed(value: Any, path: Path, other: Any) -> Any:
    if not path:
        return other
    value = deepcopy(value)
    value[path[0]] = changed(value[path[0]], path[1:], other)
    return value


@pytest.mark.parametrize("model", BODIES, ids=lambda model: model.__name__)
def test_what_the_schema_does_not_allow_is_refused_where_it_is_wrong(model: type[BaseModel]) -> None:
    schema = body_schema(model)
    allowed = Draft202012Validator(schema)
    seen = 0
    for example in schema.get("examples") or [EXAMPLES[model]]:
        assert allowed.is_valid(example)
        read_model(model, example)
        for path, other in outside(schema, example):
            body = changed(example, path, other)
            if allowed.is_valid(body):
                continue
            with pytest.raises(InvalidField) as refused:
                read_model(model, body)
            where = ".".join(str(part) for part in path)
            assert all(each["path"].startswith(where) for each in refused.value.extra["errors"]), (path, other)
            seen += 1
    assert seen > 10


@given(JSON)
def test_whatever_is_sent_is_read_or_refused(value: object) -> None:
    for model in (RuleBody, WebhookBody):
        with suppress(InvalidField):
            read_model(model, value)


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


@pytest.mark.parametrize(("opening", "closing"), [(b"[", b"]"), (b'{"a":', b"}")])
@pytest.mark.parametrize("depth", [20, 300, 900])
def test_what_is_nested_deeply_is_refused(opening: bytes, closing: bytes, depth: int) -> None:
    deep = orjson.loads(opening * depth + b"1" + closing * depth)
    assert errors({**RULE, "name": deep})[0][0].startswith("name")
    assert errors(deep)


@pytest.mark.parametrize("path", ["", "robots"])
def test_of_too_many_fields_only_the_number_is_named(path: str) -> None:
    many = {f"k{index}": 1 for index in range(60_000)}
    assert errors({**RULE, path: many} if path else many) == [(path, "at most 100 fields", "got 60000")]


def test_what_others_read_may_have_any_size() -> None:
    """Such as the goal of an action, which is checked against its message type."""
    deep = orjson.loads(b"[" * 900 + b"]" * 900)
    goal = {f"k{index}": deep for index in range(200)}
    assert read_fields(SendGoalCommand, {"goal": goal}).goal is goal


@pytest.mark.parametrize(
    ("fields", "wrong"),
    [
        ({"robot": 7, "goal": {}}, [("robot", "a valid string", "got 7")]),
        (
            {"gaol": {}, "action": []},
            [
                ("action", "a valid string", "got []"),
                ("gaol", "one of id, op, action, robot, goal, idempotency_key", "got an unknown field"),
            ],
        ),
        ({f"k{index}": 1 for index in range(60_000)}, [("", "at most 100 fields", "got 60000")]),
    ],
)
def test_what_is_wrong_in_a_command_is_said_by_field(fields: dict[str, Any], wrong: list[tuple[str, str, str]]) -> None:
    with pytest.raises(InvalidField) as refused:
        read_fields(SendGoalCommand, fields)
    assert [(each["path"], each["expected"], each["detail"]) for each in refused.value.extra["errors"]] == wrong


def test_null_is_as_if_a_text_were_left_out() -> None:
    read_fields(SubscribeCommand, {"id": "1", "goal_id": None, "include": None, "max_rate": None, "feedback": None})

"""A body is what its schema says, and what is wrong in it is said by field, in our words."""

from typing import Annotated, Any

import orjson
import pytest
from pydantic import BaseModel, Field

from dock_gateway.access.schema import PasswordBody, TokenBody, UserBody
from dock_gateway.core.errors import InvalidField
from dock_gateway.fleet.schema import AcknowledgementBody, LabelBody
from dock_gateway.goals.schema import NoteBody, TagsBody
from dock_gateway.http.bodies import Name60, read_fields, read_model
from dock_gateway.http.queries import EVENT_ID
from dock_gateway.http.requests import LINE_OF_TEXT
from dock_gateway.http.schema import RobotSelection, Schema
from dock_gateway.streams.command_schema import SendGoalCommand, SubscribeCommand
from tests.support.bodies import expect_refused

# Of these, the schema has no example.
EXAMPLES: dict[type[BaseModel], dict[str, Any]] = {
    PasswordBody: {"old": "correct horse", "new": "another horse"},
    AcknowledgementBody: {"by": "Ada"},
    LabelBody: {"display_name": "Left forklift", "groups": ["hall 1", "hall 2", "forklifts"]},
}
BODIES = [*EXAMPLES, NoteBody, TagsBody, TokenBody, UserBody]


class Selected(Schema):
    """A body with an object in it."""

    name: Name60
    robots: RobotSelection


SELECTED: dict[str, Any] = {"name": "a", "robots": {"all": True}}


def errors(value: object) -> list[tuple[str, str, str]]:
    with pytest.raises(InvalidField) as refused:
        read_model(Selected, value)
    return [(each["path"], each["expected"], each["detail"]) for each in refused.value.extra["errors"]]


@pytest.mark.parametrize("model", BODIES, ids=lambda model: model.__name__)
def test_what_the_schema_does_not_allow_is_refused_where_it_is_wrong(model: type[BaseModel]) -> None:
    expect_refused(model, *([EXAMPLES[model]] if model in EXAMPLES else []))


@pytest.mark.parametrize(("opening", "closing"), [(b"[", b"]"), (b'{"a":', b"}")])
@pytest.mark.parametrize("depth", [20, 300, 900])
def test_what_is_nested_deeply_is_refused(opening: bytes, closing: bytes, depth: int) -> None:
    deep = orjson.loads(opening * depth + b"1" + closing * depth)
    assert errors({**SELECTED, "name": deep})[0][0].startswith("name")
    assert errors(deep)


@pytest.mark.parametrize("path", ["", "robots"])
def test_of_too_many_fields_only_the_number_is_named(path: str) -> None:
    many = {f"k{index}": 1 for index in range(60_000)}
    assert errors({**SELECTED, path: many} if path else many) == [(path, "at most 100 fields", "got 60000")]


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
                ("gaol", "one of id, op, action, verb, robot, goal, idempotency_key", "got an unknown field"),
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


class Lengths(Schema):
    """A body with limits."""

    some: Annotated[tuple[int, ...], Field(min_length=1, max_length=2)] = (1,)
    short: Annotated[str, Field(min_length=2, max_length=3)] = "ab"
    line: Annotated[str, Field(pattern=f"^{LINE_OF_TEXT.pattern}$")] = "a"
    after: Annotated[str, Field(pattern=f"^{EVENT_ID.pattern}$")] = f"{1:020}-a"
    odd: Annotated[str, Field(pattern="^a$")] = "a"


@pytest.mark.parametrize(
    ("body", "expected", "detail"),
    [
        ({"some": []}, "at least 1 item", "got []"),
        ({"some": [1, 2, 3]}, "at most 2 items", "got [1, 2, 3]"),
        ({"some": None}, "a valid array", "got null"),
        ({"some": True}, "a valid array", "got true"),
        ({"short": "a"}, "at least 2 characters", "got 'a'"),
        ({"short": "abcd"}, "at most 3 characters", "got 'abcd'"),
        ({"line": "\n"}, "text in one line", "got '\\n'"),
        ({"after": "x"}, "the id of an event", "got 'x'"),
        ({"odd": "b"}, "a text of the form that is documented at /docs", "got 'b'"),
    ],
)
def test_what_is_expected_is_said_in_plain_words(body: dict[str, Any], expected: str, detail: str) -> None:
    with pytest.raises(InvalidField) as refused:
        read_model(Lengths, body)
    (error,) = refused.value.extra["errors"]
    assert (error["expected"], error["detail"]) == (expected, detail)

"""What arguments are put where, and what is wrong with a template whatever its arguments."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.extensions.missions.templates.parameters import (
    Filling,
    at_arguments,
    check_steps,
    require_arguments,
)

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=10,
)


def escaped(value: Any) -> Any:
    """Return a value as a template writes it."""
    if isinstance(value, dict):
        return {key: escaped(item) for key, item in value.items()}
    if isinstance(value, list):
        return [*map(escaped, value)]
    return f"${value}" if isinstance(value, str) and value.startswith("$") else value


@given(JSON, JSON)
def test_a_template_can_have_any_value_and_its_arguments_are_not_read(value: Any, argument: Any) -> None:
    filling = Filling({"a": argument})
    assert filling.fill([escaped(value), "$a"], "steps") == [value, argument]
    assert (filling.places, filling.wrong) == ({"steps.1": "a"}, [])


def test_only_whole_values_are_parameters() -> None:
    value = {"$a": ["$a", "x$a", "$$a", "$$$a", {"b": "$a"}]}
    filling = Filling({"a": {"c": "$a"}})
    filled = {"$a": [{"c": "$a"}, "x$a", "$a", "$$a", {"b": {"c": "$a"}}]}
    assert filling.fill(value, "steps") == filled
    assert filling.places == {"steps.$a.0": "a", "steps.$a.4.b": "a"}


def wrong(steps: list[Any], **defaults: Any) -> list[str]:
    """Return the paths of what is wrong with a template."""
    try:
        check_steps(steps, defaults)
    except InvalidField as error:
        return [each.path for each in error.errors]
    return []


DRIVE: dict[str, Any] = {"navigate": {"place": "$shelf"}}


@pytest.mark.parametrize(
    ("steps", "defaults", "paths"),
    [
        ([DRIVE], {"shelf": None}, []),
        ([DRIVE], {}, ["steps.0.navigate.place"]),
        ([{"dock": {}}], {"shelf": None}, ["parameters.shelf"]),
        ([{"notify": {"text": "$5"}}], {}, ["steps.0.notify.text"]),
        ([{"notify": {"text": "$"}}], {}, ["steps.0.notify.text"]),
        ([{"notify": {"text": "$$5, or $5"}}], {}, []),
        ([DRIVE, {"fly": {}}], {"shelf": None}, ["steps.1.fly"]),
        ([DRIVE | {"tries": 0}], {"shelf": None}, ["steps.0.tries"]),
        ([{"wait": {"seconds": "$s"}}], {"s": None}, []),
        ([{"wait": {"seconds": "$s"}}], {"s": 5}, []),
        ([{"wait": {"seconds": "$s"}}], {"s": "long"}, ["steps.0.wait.seconds"]),
        (["$step"], {"step": None}, []),
        (["$step"], {"step": {"dock": {}}}, []),
        (["$step"], {"step": {"fly": {}}}, ["steps.0.fly"]),
        ([{"repeat": {"steps": ["$step"], "times": "$n"}}], {"step": None, "n": None}, []),
        ([{"repeat": {"steps": [{"notify": {"text": "$t"}}]}}], {"t": None}, ["steps.0.repeat"]),
        ([{"dock": {}, "on_failure": {"go_to": "end"}}], {}, ["steps.0.on_failure.go_to"]),
        ([{"dock": {}, "on_failure": {"go_to": "end"}}, {"dock": {}, "name": "$n"}], {"n": None}, []),
        ([{"dock": {}, "on_failure": {"go_to": "$n"}}, {"dock": {}}], {"n": None}, []),
        ([{"dock": {"dock_id": "$d"}}, {"action": {"name": "fly"}}], {"d": None}, ["steps.1.action.name"]),
    ],
)
def test_what_is_wrong_whatever_the_arguments(steps: list[Any], defaults: dict[str, Any], paths: list[str]) -> None:
    assert wrong(steps, **defaults) == paths


def test_each_parameter_gets_a_value() -> None:
    assert require_arguments({"a": None, "b": 1}, {"a": 5, "b": None, "c": 6}) == {"a": None, "b": 1, "c": 6}
    with pytest.raises(InvalidField) as caught:
        require_arguments({"d": 1}, {"a": 5, "b": None})
    assert [(each.path, each.expected) for each in caught.value.errors] == [
        ("arguments.d", "one of a, b"),
        ("arguments.b", "a value"),
    ]


def test_what_is_wrong_with_an_argument_is_said_of_it() -> None:
    places = {"steps.0.action.goal": "goal", "steps.1": "step"}
    paths = ["steps.0.action.goal.order", "steps.1", "steps.10", "steps.0.action.goals", "robot"]
    with pytest.raises(InvalidField) as caught, at_arguments(places):
        raise InvalidField([FieldError(path, "a value", "got none") for path in paths])
    found = [each.path for each in caught.value.errors]
    assert found == ["arguments.goal.order", "arguments.step", "steps.10", "steps.0.action.goals", "robot"]

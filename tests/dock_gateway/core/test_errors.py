"""One shape for every error, and no two errors of the same name with different meaning."""

import orjson
import pytest

from dock_gateway.core import errors
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField
from dock_gateway.http.problems import problem_response

CLASSES = [value for value in vars(errors).values() if isinstance(value, type) and issubclass(value, GatewayError)]


@pytest.mark.parametrize("error_class", [c for c in CLASSES if c is not InvalidField])
def test_every_error_is_a_problem_document(error_class: type[GatewayError]) -> None:
    response = problem_response(error_class("a sentence", goal_id="1"))
    document = orjson.loads(response.body)
    assert response.media_type == "application/problem+json"
    assert response.status_code == document["status"] >= 400
    assert document["code"] == error_class.code
    assert document["detail"] == "a sentence"
    assert document["goal_id"] == "1"
    assert set(document) == {"type", "title", "status", "code", "detail", "goal_id"}


def test_codes_are_distinct() -> None:
    assert len({error_class.code for error_class in CLASSES}) == len(CLASSES)


def test_a_field_error_says_where_what_and_what_instead() -> None:
    error = InvalidField([FieldError("a.b", "a number", "got a string"), FieldError("", "an object", "got null")])
    assert error.detail == "a.b: expected a number, got a string; body: expected an object, got null"
    assert error.problem()["errors"][0] == {
        "in": "body",
        "path": "a.b",
        "expected": "a number",
        "detail": "got a string",
    }


def test_a_query_parameter_of_rest_is_a_field_of_a_message() -> None:
    with pytest.raises(InvalidField) as refused, errors.fields_of_a_message():
        raise InvalidField([FieldError("robot", "a name", "got none", "query")])
    assert refused.value.errors == [FieldError("robot", "a name", "got none", "body")]


def test_a_full_queue_says_when_to_come_back() -> None:
    assert problem_response(errors.TooManyRequests("full")).headers["retry-after"] == "1"


def test_a_sentence_does_not_repeat_all_that_a_client_sends() -> None:
    assert len(GatewayError("x" * 100_000).detail) == errors.MAX_DETAIL + 1

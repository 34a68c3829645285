"""The contract stays: what was promised is found in today's document, and a change that breaks it is noticed."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.compatibility import METHODS, Changes, compare, for_programs

ROOT = Path(__file__).parents[3]
DOCUMENT: dict[str, Any] = for_programs(orjson.loads((ROOT / "frontend/openapi.json").read_bytes()))
TEXT = orjson.dumps(DOCUMENT)
Document = dict[str, Any]


def promised(document: Document) -> list[tuple[str, str]]:
    """The operations of a document that are promised, by path and method."""
    return [
        (path, method)
        for path, item in document["paths"].items()
        for method in METHODS
        if method in item and "x-stability" not in item[method]
    ]


def reached(document: Document, part: object, names: set[str]) -> set[str]:
    """The names of the schemas below a part of a document."""
    if isinstance(part, dict):
        name = part.get("$ref", "").rpartition("/")[2] if isinstance(part.get("$ref"), str) else ""
        if name and name not in names:
            names.add(name)
            reached(document, document["components"]["schemas"][name], names)
        for item in part.values():
            reached(document, item, names)
    elif isinstance(part, list):
        for item in part:
            reached(document, item, names)
    return names


def answered(document: Document) -> list[tuple[str, str]]:
    """The fields of objects that promised operations answer with, by the names of the schema and the field."""
    names: set[str] = set()
    for path, method in promised(document):
        for status, answer in document["paths"][path][method]["responses"].items():
            if status.startswith("2"):
                reached(document, answer, names)
    schemas = document["components"]["schemas"]
    return [(name, field) for name in sorted(names) for field in schemas[name].get("properties", {})]


OPERATIONS, FIELDS = promised(DOCUMENT), answered(DOCUMENT)
PARAMETERS = [
    (path, method, number)
    for path, method in OPERATIONS
    for number, _ in enumerate(DOCUMENT["paths"][path][method].get("parameters", ()))
]


def is_typed(schema: str, field: str) -> bool:
    """Whether the type of a field is promised: a parameter's value may be anything."""
    described = DOCUMENT["components"]["schemas"][schema]["properties"][field]
    return not described.keys().isdisjoint(("type", "$ref", "anyOf", "oneOf", "const", "enum"))


def changed(change: Callable[[Document], object]) -> Changes:
    after = orjson.loads(TEXT)
    change(after)
    return compare(DOCUMENT, after)


def test_nothing_has_changed() -> None:
    assert changed(lambda _: None) == Changes()
    assert len(OPERATIONS) > 50
    assert len(FIELDS) > 200


@given(st.sampled_from(OPERATIONS))
def test_an_operation_that_is_gone_is_noticed(operation: tuple[str, str]) -> None:
    path, method = operation
    found = changed(lambda document: document["paths"][path].pop(method))
    assert found.broken == [f"{method.upper()} {path}: is gone"]


@given(st.sampled_from(OPERATIONS))
def test_an_operation_may_be_deprecated_and_then_go(operation: tuple[str, str]) -> None:
    path, method = operation
    before = orjson.loads(TEXT)
    before["paths"][path][method]["deprecated"] = True
    assert compare(DOCUMENT, before) == Changes(deprecated=[f"{method.upper()} {path}"])
    after = orjson.loads(orjson.dumps(before))
    after["paths"][path].pop(method)
    assert compare(before, after) == Changes()


@given(st.sampled_from(FIELDS))
def test_a_field_of_an_answer_that_is_gone_is_noticed(field: tuple[str, str]) -> None:
    schema, name = field
    found = changed(lambda document: document["components"]["schemas"][schema]["properties"].pop(name))
    assert any(name in line for line in found.broken)


@given(st.sampled_from([field for field in FIELDS if is_typed(*field)]))
def test_a_field_of_an_answer_with_another_type_is_noticed(field: tuple[str, str]) -> None:
    schema, name = field
    found = changed(
        lambda document: document["components"]["schemas"][schema]["properties"].update({name: {"type": "made-up"}})
    )
    assert found.broken


@given(st.sampled_from(FIELDS), st.sampled_from(["string", "object", "null"]))
def test_a_field_may_be_added_to_an_answer(field: tuple[str, str], kind: str) -> None:
    schema, _ = field
    found = changed(
        lambda document: document["components"]["schemas"][schema]["properties"].update({"made_up": {"type": kind}})
    )
    assert not found.broken
    assert any("made_up" in line for line in found.added)


@given(st.sampled_from(PARAMETERS))
def test_a_parameter_that_is_gone_is_noticed(parameter: tuple[str, str, int]) -> None:
    path, method, number = parameter
    found = changed(lambda document: document["paths"][path][method]["parameters"].pop(number))
    assert len(found.broken) == 1


@given(st.sampled_from(OPERATIONS), st.booleans())
def test_a_parameter_may_be_added_if_it_is_optional(operation: tuple[str, str], required: bool) -> None:
    path, method = operation
    more = {"in": "query", "name": "made_up", "required": required, "schema": {"type": "string"}}
    found = changed(lambda document: document["paths"][path][method].setdefault("parameters", []).append(more))
    assert bool(found.broken) is required
    assert bool(found.added) is not required


OBJECT: Document = {"type": "object", "properties": {"name": {"type": "string"}}, "required": ["name"]}


def one(schema: Document, *, sent: bool) -> Document:
    """A document with one schema, which is sent or read."""
    content = {"content": {"application/json": {"schema": {"$ref": "#/components/schemas/Thing"}}}}
    operation = {"responses": {"200": content if sent else {}}, **({} if sent else {"requestBody": content})}
    return {"paths": {"/things": {"post": operation}}, "components": {"schemas": {"Thing": schema}}}


def numbers(**limits: int) -> Document:
    return {"type": "object", "properties": {"count": {"type": "integer", **limits}}}


def texts(*values: str) -> Document:
    return {"type": "object", "properties": {"mode": {"type": "string", "enum": [*values]}}}


@pytest.mark.parametrize(
    ("before", "after", "breaks_answer", "breaks_request"),
    [
        (OBJECT, {**OBJECT, "required": []}, True, False),
        ({**OBJECT, "required": []}, OBJECT, False, True),
        (numbers(maximum=9), numbers(maximum=10), False, False),
        (numbers(maximum=9), numbers(maximum=8), False, True),
        (numbers(), numbers(minimum=0), False, True),
        (numbers(minimum=1), numbers(minimum=0), False, False),
        (texts("a"), texts("a", "b"), False, False),
        (texts("a", "b"), texts("a"), False, True),
        (numbers(), {"type": "object", "properties": {"count": {"type": "number"}}}, True, False),
        (numbers(), {"type": "object", "properties": {"count": {"type": ["integer", "null"]}}}, True, False),
        ({"type": "object", "properties": {"count": {"type": ["integer", "null"]}}}, numbers(), False, True),
        ({"type": "array", "items": numbers()}, {"type": "array", "items": texts("a")}, True, True),
    ],
)
def test_the_rules(before: Document, after: Document, breaks_answer: bool, breaks_request: bool) -> None:
    assert bool(compare(one(before, sent=True), one(after, sent=True)).broken) is breaks_answer
    assert bool(compare(one(before, sent=False), one(after, sent=False)).broken) is breaks_request

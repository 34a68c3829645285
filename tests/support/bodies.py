"""Bodies that a schema does not allow: each is refused where it is wrong."""

from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from pydantic import BaseModel

from dock_gateway.core.errors import InvalidField
from dock_gateway.http.bodies import body_schema, read_model

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


def expect_refused(model: type[BaseModel], *examples: dict[str, Any]) -> None:
    """Change each field of the schema's examples, or of these, to what the schema does not allow."""
    schema = body_schema(model)
    allowed = Draft202012Validator(schema)
    seen = 0
    for example in examples or schema["examples"]:
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

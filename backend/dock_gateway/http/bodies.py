"""Bodies as pydantic models: one declaration is the reader, the JSON Schema and the example."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Generic, TypeVar

import orjson
from fastapi import Depends, Request
from pydantic import AfterValidator, BaseModel, Field, ValidationError, WithJsonSchema
from pydantic_core import PydanticCustomError

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.namespace import is_namespace, normalize_namespace
from dock_gateway.http.principal import read_signed_json
from dock_gateway.http.queries import EVENT_ID
from dock_gateway.http.requests import (
    LINE_OF_TEXT,
    MAX_GROUP,
    MAX_TAG,
    ROBOT_PATTERN,
    SLUG,
    is_name,
    name_schema,
    read_json,
)
from dock_gateway.setting_types import LONGEST_NAME, TOPIC

ModelT = TypeVar("ModelT", bound=BaseModel)
MAX_ERRORS = 20
# No body has more. The errors of a body of 60,000 unknown fields would take 0.2 s of the event loop.
MAX_FIELDS, MAX_DEPTH = 100, 20


@dataclass(frozen=True)
class BodyReader(Generic[ModelT]):
    """Reads the body of a request as a model: the dependency behind `Body` and `SignedBody`.

    Attributes:
        model: The model.
        signed: Whether the name of who sent it is read as `by`.
    """

    model: type[ModelT]
    signed: bool = False

    @property
    def schema(self) -> dict[str, Any]:
        """The JSON Schema of the body, without references."""
        return body_schema(self.model)

    async def __call__(self, request: Request) -> ModelT:
        """Return the body.

        Raises:
            InvalidField: It is not what the model describes. Lists the invalid fields.
            MalformedRequest: It is not JSON, too large, too slow or cut off, or has another content type.
        """
        return read_model(self.model, await (read_signed_json if self.signed else read_json)(request))


if TYPE_CHECKING:
    Body = Annotated[ModelT, "the body of the request"]
    SignedBody = Annotated[ModelT, "the body of the request, with the name of who sent it as `by`"]
else:

    class Body:
        """`Body[Label]` is `Label` to whoever reads it, and tells FastAPI to read it from the body."""

        def __class_getitem__(cls, model: type) -> Any:
            return Annotated[model, Depends(BodyReader(model))]

    class SignedBody:
        """`SignedBody[NoteBody]` is `Body[NoteBody]` with the name of who sent it as `by`, if it is known."""

        def __class_getitem__(cls, model: type) -> Any:
            return Annotated[model, Depends(BodyReader(model, signed=True))]


def read_model(model: type[ModelT], value: object) -> ModelT:
    """Return a decoded body as a model.

    Raises:
        InvalidField: It is not what the model describes. Lists the invalid fields.
    """
    _check_size(value)
    with _invalid_fields(model):
        return model.model_validate_json(orjson.dumps(value))


def read_fields(model: type[ModelT], fields: dict[str, Any]) -> ModelT:
    """Return an object as a model whose fields are texts, or values of any size that are read elsewhere.

    Raises:
        InvalidField: It is not what the model describes. Lists the invalid fields.
    """
    _check_size(dict.fromkeys(fields))
    with _invalid_fields(model):
        return model.model_validate(fields)


@contextmanager
def _invalid_fields(model: type[BaseModel]) -> Iterator[None]:
    """Report the errors of a model as those of fields."""
    try:
        yield
    except ValidationError as error:
        schema = body_schema(model)
        raise InvalidField([_field_error(item, schema) for item in error.errors()[:MAX_ERRORS]]) from None


@cache
def body_schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON Schema of a body, without references."""
    schema = model.model_json_schema()
    parts = schema.pop("$defs", {})

    def inline(value: Any) -> Any:
        if isinstance(value, list):
            return [inline(item) for item in value]
        if not isinstance(value, dict):
            return value
        part = inline(parts[value["$ref"].rpartition("/")[2]]) if value.get("$ref", "").startswith("#/$defs/") else {}
        return {
            key: inline(item)
            for key, item in {**part, **value}.items()
            if key != "title" and not (part and key == "$ref")
        }

    inlined: dict[str, Any] = inline(schema)
    return inlined


def _check_size(value: object, path: tuple[str, ...] = ()) -> None:
    """Refuse an object with too many fields, or one that is nested too deeply.

    Raises:
        InvalidField: It is.
    """
    if len(path) > MAX_DEPTH:
        raise InvalidField([FieldError(".".join(path), f"at most {MAX_DEPTH} levels", "got more")])
    if isinstance(value, dict):
        if len(value) > MAX_FIELDS:
            raise InvalidField([FieldError(".".join(path), f"at most {MAX_FIELDS} fields", f"got {len(value)}")])
        for key, item in value.items():
            _check_size(item, (*path, key[:200]))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            if isinstance(item, dict | list):
                _check_size(item, (*path, str(index)))


def expected(what: str, detail: str | None = None, path: str = "") -> PydanticCustomError:
    """Return the error of a validator: the expected value, the received one, and the path below the field."""
    return PydanticCustomError("expected", "{expected}", {"expected": what, "detail": detail, "path": path})


def _field_error(item: Any, schema: dict[str, Any]) -> FieldError:
    context = item.get("ctx", {})
    path = ".".join(str(part)[:200] for part in (*item["loc"], *filter(None, [context.get("path")])))
    match item["type"]:
        case "missing":
            return FieldError(path, "a value", "it is missing")
        case "extra_forbidden":
            known = ", ".join(_fields(schema, item["loc"][:-1]))
            return FieldError(path, f"one of {known}" if known else "no field", "got an unknown field")
        case "expected":
            return FieldError(path, context["expected"], context["detail"] or got(item["input"]))
    return FieldError(path, expectation(item), got(item["input"]))


# What a text has to be, by its pattern.
FORMS = {
    f"^{LINE_OF_TEXT.pattern}$": "text in one line",
    f"^{EVENT_ID.pattern}$": "the id of an event",
    f"^{TOPIC.pattern}$": "a name on the ROS graph, such as /robot1/dock",
    r"^[^\x00]*$": "text without NUL",
    f"^{SLUG.pattern}$": "up to 40 lower-case letters, digits and hyphens between them",
}
# What is expected of the length of a list or a text, by pydantic's type of the error.
LENGTHS = {
    "too_short": ("at least", "min_length", "item"),
    "too_long": ("at most", "max_length", "item"),
    "string_too_short": ("at least", "min_length", "character"),
    "string_too_long": ("at most", "max_length", "character"),
}


def expectation(item: Mapping[str, Any]) -> str:
    """Return in plain words what an error of pydantic says that it expects."""
    kind, context, message = item["type"], item.get("ctx", {}), str(item["msg"])
    if kind in LENGTHS:
        bound, limit, what = LENGTHS[kind]
        number = context[limit]
        return f"{bound} {number} {what}{'' if number == 1 else 's'}"
    if kind == "string_pattern_mismatch":
        return FORMS.get(context["pattern"], "a text of the form that is documented at /docs")
    return message.removeprefix("Input should be ").removeprefix("Value error, ").partition(", unable to parse")[0]


def _fields(schema: dict[str, Any], path: tuple[int | str, ...]) -> list[str]:
    """Return the names of the fields at a path."""
    for part in path:
        options = [
            option.get("properties", {}).get(part) or option.get("items") or option.get("additionalProperties")
            for option in _options(schema)
        ]
        schema = next(filter(None, options))
    return [name for option in _options(schema) for name in option.get("properties", {})]


def _options(schema: dict[str, Any]) -> list[dict[str, Any]]:
    options: list[dict[str, Any]] = schema.get("anyOf", [schema])
    return options


def _name(longest: int) -> AfterValidator:
    def check(value: str) -> str:
        if not is_name(value, longest):
            raise expected(f"1 to {longest} characters, in one line")
        return value.strip()

    return AfterValidator(check)


def _robot(value: str) -> str:
    if not is_namespace(value):
        raise expected(f"a ROS namespace such as /robot1, of up to {LONGEST_NAME} characters")
    return normalize_namespace(value)


def _unique(values: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(values))


# A line of text without surrounding spaces, of up to 60 characters or as many as a tag or a group has.
Name60 = Annotated[str, _name(60), WithJsonSchema(name_schema(60))]
TagName = Annotated[str, _name(MAX_TAG), WithJsonSchema(name_schema(MAX_TAG))]
GroupName = Annotated[str, _name(MAX_GROUP), WithJsonSchema(name_schema(MAX_GROUP))]
# An id that people choose, such as that of a place.
Slug = Annotated[str, Field(pattern=f"^{SLUG.pattern}$")]
# The namespace of a robot, which need not be on the ROS graph.
RobotName = Annotated[
    str,
    AfterValidator(_robot),
    WithJsonSchema({"type": "string", "maxLength": LONGEST_NAME, **ROBOT_PATTERN}),
]
Unique = AfterValidator(_unique)

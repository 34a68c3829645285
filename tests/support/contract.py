"""The contract of the API as lines of text: paths, roles, parameters, bodies, answers and the fields of each shape.

It says nothing about how the OpenAPI document is written: a body that is given inline and one that is a component, or
a field that is null by `type` and one that is so by `anyOf`, are the same line. So a line that changes is a change that
a client may notice. `python -m tests.support.contract` prints the contract of this version.
"""

from collections.abc import Iterator
from typing import Any

from dock_gateway.app import create_app
from dock_gateway.settings import Settings

Json = dict[str, Any]

# What limits a value, besides its type.
LIMITS = (
    "const",
    "enum",
    "pattern",
    "format",
    "minimum",
    "exclusiveMinimum",
    "maximum",
    "exclusiveMaximum",
    "minLength",
    "maxLength",
    "minItems",
    "maxItems",
    "minProperties",
)


def contract(document: Json) -> list[str]:
    """Return the contract of an OpenAPI document, in order."""
    schemas = document["components"]["schemas"]
    lines = [f"{where} {text}" for where, text in _operations(document, schemas)]
    for name in sorted(schemas):
        lines += [f"{name}{path} {text}" for path, text in _fields(schemas[name], schemas, follow=False)]
    return sorted(dict.fromkeys(lines))


def _operations(document: Json, schemas: Json) -> Iterator[tuple[str, str]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            where = f"{method.upper()} {path}"
            yield where, f"role {operation.get('x-role', 'none')}"
            for parameter in operation.get("parameters", ()):
                place = f"{parameter['in']}.{parameter['name']}"
                for inner, text in _fields(parameter["schema"], schemas, required=parameter.get("required", False)):
                    yield where, f"{place}{inner} {text}"
            for kind, content in operation.get("requestBody", {}).get("content", {}).items():
                for inner, text in _fields(content["schema"], schemas, required=operation["requestBody"]["required"]):
                    yield where, f"body[{kind}]{inner} {text}"
            errors = []
            for status, answer in operation["responses"].items():
                kinds = {kind: _type(content.get("schema", {})) for kind, content in answer.get("content", {}).items()}
                if kinds == {"application/problem+json": "Problem"}:
                    errors.append(status)
                else:
                    yield where, " ".join([status, *(f"{kind} {shape}" for kind, shape in kinds.items())])
            yield where, " ".join(["errors", *sorted(errors)])


def _fields(
    schema: Json,
    schemas: Json,
    *,
    required: bool = False,
    follow: bool = True,
    path: str = "",
    above: tuple[str, ...] = (),
) -> Iterator[tuple[str, str]]:
    """Yield each field below a schema, with its type and limits; with `follow` also those of components."""
    null, options = _options(schema, schemas, follow=follow, above=above)
    for option, names in options:
        limits = "".join(f" {key}={_plain(option[key])}" for key in LIMITS if key in option)
        closed = " closed" if option.get("additionalProperties") is False else ""
        yield path, f"{_type(option)}{limits}{closed}{' or null' if null else ''}{' required' if required else ''}"
        for name, inner in option.get("properties", {}).items():
            needed = name in option.get("required", ())
            yield from _fields(
                inner, schemas, required=needed, follow=follow, path=f"{path}.{name}", above=(*above, *names)
            )
        if isinstance(items := option.get("items"), dict):
            yield from _fields(items, schemas, follow=follow, path=f"{path}[]", above=(*above, *names))


def _options(
    schema: Json, schemas: Json, *, follow: bool, above: tuple[str, ...]
) -> tuple[bool, list[tuple[Json, tuple[str, ...]]]]:
    """Return whether a value may be null, and what else it may be, each with the components that led to it."""
    if isinstance(kinds := schema.get("type"), list):
        options = [schema | {"type": kind} for kind in kinds if kind != "null"]
        return "null" in kinds, [(option, ()) for option in options]
    if schema.get("type") == "null":
        return True, []
    if "$ref" in schema and follow and (name := schema["$ref"].rpartition("/")[2]) not in above:
        null, options = _options(schemas[name], schemas, follow=True, above=(*above, name))
        return null, [(option, (name, *names)) for option, names in options]
    alternatives = schema.get("anyOf") or schema.get("oneOf")
    if not alternatives or "properties" in schema:
        return False, [(schema, ())]
    found = [_options(each, schemas, follow=follow, above=above) for each in alternatives]
    return any(null for null, _ in found), [option for _, options in found for option in options]


def _plain(value: object) -> object:
    return f"{value:.12g}" if isinstance(value, int | float) and not isinstance(value, bool) else value


def _type(schema: Json) -> str:
    if "$ref" in schema:
        return str(schema["$ref"].rpartition("/")[2])
    if alternatives := schema.get("anyOf") or schema.get("oneOf"):
        return "|".join(sorted(_type(each) for each in alternatives))
    if schema.get("type") == "array":
        return f"array<{_type(schema.get('items', {}))}>"
    if "type" not in schema and all(isinstance(value, str) for value in schema.get("enum", [0])):
        return "string"
    return str(schema.get("type", "any"))


if __name__ == "__main__":
    print("\n".join(contract(create_app(Settings()).openapi())))

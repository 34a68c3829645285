"""Pages of the documentation site that are made from the OpenAPI document: the operations, and their schemas."""

import re
from collections.abc import Iterator
from itertools import groupby
from typing import Any

Document = dict[str, Any]

OPERATIONS_HEAD = """# Operations

All requests of the [API](api.md), from the gateway's OpenAPI document: `/openapi.json`. On a running gateway, the page
`/docs` can send them. An error is a [`Problem`](schemas.md#problem) with one of these [codes](errors.md). Where the
gateway asks for a [login](access.md), a request needs at least the role that is named.
"""
SCHEMAS_HEAD = """# Schemas

What the [operations](operations.md) and the [streams](streams.md) take and give. A field that is not *optional* is
always there.
"""
LIMITS = {
    "minimum": "≥ {}",
    "maximum": "≤ {}",
    "minLength": "length ≥ {}",
    "maxLength": "length ≤ {}",
}


def anchor(name: str) -> str:
    """The anchor of a schema's or an operation's heading."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def cell(text: str) -> str:
    """A text that fits into a cell of a table."""
    return re.sub(r"\s+", " ", text).replace("|", "\\|")


def kind(schema: Document) -> str:
    """The type of a value, in a few words, with links to schemas."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](schemas.md#{anchor(name)})"
    for union in ("anyOf", "oneOf"):
        if union in schema:
            return " or ".join(dict.fromkeys(map(kind, schema[union])))
    if "enum" in schema or "const" in schema:
        return ", ".join(f"`{value}`" for value in schema.get("enum", [schema.get("const")]))
    types = schema.get("type", "any")
    if types == "array":
        return f"array of {kind(schema.get('items', {}))}"
    if types == "object" and isinstance(schema.get("additionalProperties"), dict):
        return f"object of {kind(schema['additionalProperties'])}"
    return " or ".join(types) if isinstance(types, list) else str(schema.get("format") or types)


def meaning(schema: Document, text: str = "") -> str:
    """What a value is: its description, its limits and its default."""
    parts = [text or schema.get("description", "")]
    values = [one for one in schema.get("anyOf", [schema]) if one.get("type") != "null"]
    parts += [words.format(one[limit]) for one in values for limit, words in LIMITS.items() if limit in one]
    if schema.get("default") is not None:
        parts.append(f"default `{schema['default']}`")
    return cell("; ".join(part.rstrip(".") for part in parts if part))


def fields(schema: Document) -> Iterator[str]:
    """The table of an object's fields, if it has any."""
    if not schema.get("properties"):
        return
    yield "| field | type | |\n|---|---|---|\n"
    for name, value in schema["properties"].items():
        optional = "" if name in schema.get("required", []) else "*optional* "
        yield f"| `{name}` | {optional}{cell(kind(value))} | {meaning(value)} |\n"
    yield "\n"


def body(request: Document) -> Iterator[str]:
    """What an operation takes as its body."""
    for media, content in request["content"].items():
        schema = content["schema"]
        optional = "" if request.get("required") else " (optional)"
        yield f"**Body**{optional}, `{media}`: {kind(schema)}. {schema.get('description', '')}\n\n"
        yield from fields(schema)


def answers(responses: Document) -> Iterator[str]:
    """What an operation answers: the types of successes, the statuses of errors."""
    errors = sorted(status for status in responses if status >= "400")
    for status, answer in sorted(responses.items()):
        if status < "400":
            schemas = [content["schema"] for content in answer.get("content", {}).values() if "schema" in content]
            parts = [" or ".join(dict.fromkeys(map(kind, schemas))), answer["description"]]
            text = ": ".join(part for part in parts if part and part != "Successful Response")
            yield f"- **{status}** {text or 'no body'}\n"
    yield f"- errors: {', '.join(errors)}\n\n" if errors else "\n"


def operation(method: str, path: str, document: Document) -> Iterator[str]:
    """The section about an operation."""
    yield f"### `{method.upper()} {path}` {{ #{anchor(document['operationId'])} }}\n\n"
    yield f"{document.get('description', document['summary'])}\n\n"
    if "x-role" in document:
        every = ", for every robot" if document.get("x-every-robot") else ""
        yield f"Role: `{document['x-role']}`{every}.\n\n"
    if document.get("parameters"):
        yield "| parameter | in | type | |\n|---|---|---|---|\n"
    for one in document.get("parameters", []):
        text = meaning(one["schema"], one.get("description", ""))
        if "example" in one:
            text += f"; such as `{one['example']}`"
        yield f"| `{one['name']}` | {one['in']} | {cell(kind(one['schema']))} | {text.removeprefix('; ')} |\n"
    yield "\n"
    if "requestBody" in document:
        yield from body(document["requestBody"])
    yield from answers(document["responses"])


def operations_page(document: Document) -> str:
    """The page with all operations, by their tags."""
    paths = document["paths"]
    found = [(one["tags"][0], method, path, one) for path in paths for method, one in paths[path].items()]
    tags = list(dict.fromkeys(tag for tag, *_ in found))
    found.sort(key=lambda one: tags.index(one[0]))
    parts = [OPERATIONS_HEAD]
    for tag, members in groupby(found, key=lambda one: one[0]):
        parts.append(f"\n## {tag}\n\n")
        for _, method, path, one in members:
            parts += operation(method, path, one)
    return "".join(parts)


def schemas_page(document: Document) -> str:
    """The page with all schemas, by their names."""
    parts = [SCHEMAS_HEAD]
    for name, schema in sorted(document["components"]["schemas"].items(), key=lambda item: item[0].lower()):
        parts.append(f"\n## {name} {{ #{anchor(name)} }}\n\n{schema.get('description', '')}\n\n")
        parts += fields(schema)
        if not schema.get("properties"):
            parts.append(f"{kind(schema)}\n")
    return "".join(parts)

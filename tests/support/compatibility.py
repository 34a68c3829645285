"""Compares two versions of an OpenAPI document by the rules of docs/compatibility.md: what is additive, what is broken.

A request that was accepted has to be accepted, and each field of an answer has to stay, with its type. Operations that
are marked unstable may change, and so may what was deprecated.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

Schema = dict[str, Any]
METHODS = ("get", "put", "post", "delete", "patch")
# Besides requests: the settings, commands of the command line and tools of agents; see tests/support/contract.py.
OPERATIONS = (*METHODS, "set", "run", "call")
# Schemas that no operation answers with: messages of streams, and errors. Whether the gateway sends them.
ALONE = {"Event": True, "ActionEvent": True, "EchoEvent": True, "Answer": True, "Command": False, "Problem": True}
# Words and examples are for people.
FOR_PEOPLE = frozenset({"description", "summary", "title", "examples", "example", "tags"})
# A limit of a request may grow in one direction only: upwards for these, downwards for the others.
GROWING = ("maximum", "exclusiveMaximum", "maxLength", "maxItems", "maxProperties")
SHRINKING = ("minimum", "exclusiveMinimum", "minLength", "minItems", "minProperties")


@dataclass
class Changes:
    """What has changed, each as a place and a few words.

    Attributes:
        added: A client of the earlier version does not notice.
        deprecated: It goes on to work, and is to be avoided.
        broken: A client of the earlier version may fail.
    """

    added: list[str] = field(default_factory=list)
    deprecated: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return a line for each, with its kind."""
        return [f"{kind}: {line}" for kind, lines in vars(self).items() for line in sorted(set(lines))]


def for_programs(document: Any) -> Any:
    """Return a document without what is for people: what a program can rely on is left."""
    if isinstance(document, list):
        return [for_programs(item) for item in document]
    if not isinstance(document, dict):
        return document
    return {
        # A field may be called `title`: names of fields and schemas stay.
        key: {name: for_programs(item) for name, item in value.items()}
        if key in ("properties", "schemas", "paths", "headers") and isinstance(value, dict)
        else for_programs(value)
        for key, value in document.items()
        if key not in FOR_PEOPLE
    }


def compare(before: Schema, after: Schema) -> Changes:
    """Return what has changed from one version of a document to the next."""
    return _Comparison(before, after).run()


class _Comparison:
    def __init__(self, before: Schema, after: Schema) -> None:
        self._before, self._after = before, after
        self._changes = Changes()
        self._seen: set[tuple[str, str, bool]] = set()

    def run(self) -> Changes:
        before, after = dict(_operations(self._before)), dict(_operations(self._after))
        for name, operation in after.items():
            if name not in before:
                self._changes.added.append(name)
            elif operation.get("deprecated") and not before[name].get("deprecated"):
                self._changes.deprecated.append(name)
        for name, operation in before.items():
            if operation.get("deprecated") or "x-stability" in operation:
                continue
            if name not in after:
                self._changes.broken.append(f"{name}: is gone")
            else:
                self._operation(name, operation, after[name])
        for name in sorted(_schemas(self._before).keys() & ALONE.keys()):
            reference = {"$ref": f"#/components/schemas/{name}"}
            if name in _schemas(self._after):
                self._schema(name, reference, reference, sent=ALONE[name])
            else:
                self._changes.broken.append(f"{name}: is gone")
        self._names(self._before.get("names", {}), self._after.get("names", {}))
        return self._changes

    def _names(self, before: Mapping[str, str], after: Mapping[str, str]) -> None:
        """Compare names that stand for something, each with a few words about it."""
        self._changes.added += sorted(after.keys() - before.keys())
        for name, meaning in before.items():
            if name not in after:
                self._changes.broken.append(f"{name}: is gone")
            elif after[name] != meaning:
                self._changes.broken.append(f"{name}: was {meaning}, is {after[name]}")

    def _operation(self, name: str, before: Schema, after: Schema) -> None:
        if before.get("x-robot") != after.get("x-robot"):
            self._changes.broken.append(f"{name}: x-robot was {before.get('x-robot')}, is {after.get('x-robot')}")
        if before.get("operationId") != after.get("operationId"):
            self._changes.broken.append(f"{name}: its operationId was {before.get('operationId')}")
        self._parameters(name, before, after)
        new_body = _body(after)
        for media, content in _body(before).items():
            if media not in new_body:
                self._changes.broken.append(f"{name}: no longer reads {media}")
            else:
                self._schema(f"{name} body", content.get("schema", {}), new_body[media].get("schema", {}), sent=False)
        if _needs_body(after) and not _needs_body(before):
            self._changes.broken.append(f"{name}: needs a body")
        self._answers(name, before, after)

    def _answers(self, name: str, before: Schema, after: Schema) -> None:
        for status, answer in before.get("responses", {}).items():
            if not status.startswith("2"):
                continue
            if (new := after["responses"].get(status)) is None:
                self._changes.broken.append(f"{name}: no longer answers {status}")
                continue
            for media, content in answer.get("content", {}).items():
                if media not in new.get("content", {}):
                    self._changes.broken.append(f"{name} {status}: no longer answers with {media}")
                    continue
                self._schema(
                    f"{name} {status}", content.get("schema", {}), new["content"][media].get("schema", {}), sent=True
                )

    def _parameters(self, name: str, before: Schema, after: Schema) -> None:
        old, new = _parameters(before), _parameters(after)
        for key, parameter in old.items():
            if key not in new:
                self._changes.broken.append(f"{name}: {' '.join(key)} is gone")
                continue
            if new[key].get("required") and not parameter.get("required"):
                self._changes.broken.append(f"{name}: {' '.join(key)} is needed")
            self._schema(f"{name} {' '.join(key)}", parameter.get("schema", {}), new[key].get("schema", {}), sent=False)
        for key in new.keys() - old.keys():
            if new[key].get("required"):
                self._changes.broken.append(f"{name}: {' '.join(key)} is needed")
            else:
                self._changes.added.append(f"{name}: {' '.join(key)}")

    def _schema(self, place: str, before: Schema, after: Schema, *, sent: bool) -> None:
        """Compare two schemas.

        Args:
            place: Where they are.
            before: The earlier one.
            after: The later one.
            sent: Whether the gateway sends it; if not, it reads it.
        """
        names = before.get("$ref", ""), after.get("$ref", "")
        if all(names):
            if (*names, sent) in self._seen:
                return
            self._seen.add((*names, sent))
            place = f"{names[0].rpartition('/')[2]}"
        before, after = _resolved(before, self._before), _resolved(after, self._after)
        old, new = _choices(before, self._before), _choices(after, self._after)
        if len(old) > 1 or len(new) > 1:
            self._alternatives(place, old, new, sent=sent)
            return
        was, now = _type(before), _type(after)
        if was != now:
            wider = now == "any" or (was, now) == ("integer", "number")
            narrower = was == "any" or (was, now) == ("number", "integer")
            if not (narrower if sent else wider):
                self._changes.broken.append(f"{place}: was {was}, is {now}")
            return
        self._values(place, before, after, sent=sent)
        self._fields(place, before, after, sent=sent)
        if "items" in before and "items" in after:
            self._schema(f"{place}[]", before["items"], after["items"], sent=sent)
        if isinstance(rest := before.get("additionalProperties"), dict) and isinstance(
            other := after.get("additionalProperties"), dict
        ):
            self._schema(f"{place}.*", rest, other, sent=sent)

    def _alternatives(self, place: str, old: list[Schema], new: list[Schema], *, sent: bool) -> None:
        """Compare the alternatives of two schemas, each with the one of the same name or type."""
        earlier, later = _by_name(old, self._before), _by_name(new, self._after)
        for name in later.keys() - earlier.keys():
            if sent and name == "null":
                self._changes.broken.append(f"{place}: may be null")
            else:
                self._changes.added.append(f"{place}: {name}")
        for name, schema in earlier.items():
            if name in later:
                self._schema(f"{place} {name}" if name.startswith("{") else place, schema, later[name], sent=sent)
            elif not (sent and name == "null"):
                self._changes.broken.append(f"{place}: no longer {name}")

    def _values(self, place: str, before: Schema, after: Schema, *, sent: bool) -> None:
        old, new = _enumeration(before), _enumeration(after)
        if old is not None and new is not None:
            self._changes.added += [f"{place}: {value}" for value in new if value not in old]
        if not sent:
            if new is not None and (gone := [value for value in old or () if value not in new] or old is None):
                self._changes.broken.append(f"{place}: no longer takes {'other values' if gone is True else gone}")
            if "default" in before and after.get("default") != before["default"]:
                self._changes.broken.append(f"{place}: default was {before['default']}, is {after.get('default')}")
            if after.get("pattern") not in (None, before.get("pattern")):
                self._changes.broken.append(f"{place}: has the pattern {after['pattern']}")
            for keys, sign in ((GROWING, 1), (SHRINKING, -1)):
                for key in keys:
                    limit = after.get(key)
                    if limit is not None and (before.get(key) is None or sign * limit < sign * before[key]):
                        self._changes.broken.append(f"{place}: {key} was {before.get(key)}, is {limit}")
        elif before.get("format") != after.get("format"):
            self._changes.broken.append(f"{place}: was {before.get('format')}, is {after.get('format')}")

    def _fields(self, place: str, before: Schema, after: Schema, *, sent: bool) -> None:
        old, new = before.get("properties", {}), after.get("properties", {})
        was_needed, is_needed = set(before.get("required", ())), set(after.get("required", ()))
        for name, schema in old.items():
            if name not in new:
                if not schema.get("deprecated"):
                    self._changes.broken.append(f"{place}.{name}: is gone")
                continue
            if new[name].get("deprecated") and not schema.get("deprecated"):
                self._changes.deprecated.append(f"{place}.{name}")
            if sent and name in was_needed - is_needed:
                self._changes.broken.append(f"{place}.{name}: may be missing")
            self._schema(f"{place}.{name}", schema, new[name], sent=sent)
        self._changes.added += [f"{place}.{name}" for name in new.keys() - old.keys()]
        if not sent:
            self._changes.broken += [f"{place}.{name}: is needed" for name in sorted(is_needed - was_needed)]


def _operations(document: Schema) -> Iterator[tuple[str, Schema]]:
    for path, item in document["paths"].items():
        for method in OPERATIONS:
            if method in item:
                yield f"{method.upper()} {path}", item[method]


def _schemas(document: Schema) -> Mapping[str, Schema]:
    schemas: Mapping[str, Schema] = document.get("components", {}).get("schemas", {})
    return schemas


def _parameters(operation: Schema) -> dict[tuple[str, str], Schema]:
    return {(each["in"], each["name"]): each for each in operation.get("parameters", ())}


def _body(operation: Schema) -> dict[str, Schema]:
    content: dict[str, Schema] = operation.get("requestBody", {}).get("content", {})
    return content


def _needs_body(operation: Schema) -> bool:
    return bool(operation.get("requestBody", {}).get("required"))


def _resolved(schema: Schema, document: Schema) -> Schema:
    while "$ref" in schema:
        schema = _schemas(document)[schema["$ref"].rpartition("/")[2]]
    return schema


def _choices(schema: Schema, document: Schema) -> list[Schema]:
    """Return the alternatives of a schema: one, if it has none."""
    found = schema.get("anyOf") or schema.get("oneOf")
    if found is None:
        kinds = schema.get("type")
        return [{**schema, "type": kind} for kind in kinds] if isinstance(kinds, list) else [schema]
    flat: list[Schema] = []
    for each in found:
        inner = _resolved(each, document)
        flat += _choices(inner, document) if "anyOf" in inner or "oneOf" in inner else [each]
    return flat


def _by_name(schemas: list[Schema], document: Schema) -> dict[str, Schema]:
    """Return alternatives by their type.

    Objects that have a field `type` of one value, as events have, by that value; others by the name of their schema,
    or by their fields.
    """
    found: dict[str, Schema] = {}
    for schema in schemas:
        resolved = _resolved(schema, document)
        name = _type(resolved)
        if name == "object":
            fields = resolved.get("properties", {})
            if "const" in fields.get("type", {}):
                name = f"type {fields['type']['const']}"
            else:
                name = schema["$ref"].rpartition("/")[2] if "$ref" in schema else f"{{{', '.join(sorted(fields))}}}"
        found.setdefault(name, schema)
    return found


def _type(schema: Schema) -> str:
    if "type" in schema:
        return str(schema["type"])
    values = _enumeration(schema)
    if values:
        return {str: "string", bool: "boolean", int: "integer", float: "number"}.get(type(values[0]), "null")
    return "object" if "properties" in schema else "any"


def _enumeration(schema: Schema) -> list[Any] | None:
    if "const" in schema:
        return [schema["const"]]
    return schema.get("enum")

"""Compares every answer and event that a test receives with the OpenAPI document.

The clients in `clients.py` call `check_answer` and `check_event`. Nothing is raised there: a difference may appear in a
thread, or where a test expects an error. A fixture for every test fails with the differences that were noted.
"""

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import orjson
from jsonschema_rs import Draft202012Validator

PROBLEM = "application/problem+json"
# Answers that every path can give: the origin guard, the limits on input, a bug, a method that is not offered.
EVERYWHERE = {400, 403, 405, 408, 413, 414, 431, 500, 501, 503}
DOCKING = ("connect_to_charging_dock", "disconnect_from_charging_dock")
MAX_NOTED = 20
SPELLING = re.compile(r"^/(?:(?:dock|undock|actions/.+/goals)(?=/[0-9a-fA-F-]{32})|actions/.+/goals$)")

Schema = dict[str, Any]
_noted: list[str] = []


@cache
def document() -> Any:
    """The copy that the dashboard's types come from; a test keeps it fresh.

    A later version may send further fields, so answers are open there. What this one sends is described: they are
    closed here.
    """
    return _closed(orjson.loads((Path(__file__).parents[2] / "frontend" / "openapi.json").read_bytes()))


def _closed(value: Any) -> Any:
    if isinstance(value, list):
        return [_closed(item) for item in value]
    if not isinstance(value, dict):
        return value
    closed = {name: _closed(item) for name, item in value.items()}
    if value.get("type") == "object" and "properties" in value:
        closed.setdefault("additionalProperties", False)
    return closed


def noted() -> list[str]:
    """The differences since the last call, each once."""
    differences = [*dict.fromkeys(_noted)]
    _noted.clear()
    return differences


def check_answer(method: str, path: str, status: int, content_type: str, body: bytes) -> None:
    """Compare an answer with the schema of its operation, status and media type."""
    kind = content_type.partition(";")[0]
    where = f"{method} {path} → {status}"
    operation = _operation(method.lower(), path)
    if operation is None:
        if body and kind in ("application/json", PROBLEM) and path not in ("/openapi.json", "/asyncapi.json"):
            _compare(where, _reference("Problem"), body)
        return
    responses = operation["responses"]
    if str(status) not in responses and status in EVERYWHERE and kind == PROBLEM:
        _compare(where, _reference("Problem"), body)
    elif str(status) not in responses:
        _note(where, f"the status is not documented; the answer was {body[:300]!r}")
    elif body and kind not in (content := responses[str(status)].get("content", {})):
        _note(where, f"the media type is {kind or 'missing'}, not {' or '.join(content) or 'none'}")
    elif kind in ("application/json", PROBLEM):
        _compare(where, content[kind]["schema"], body)


def check_event(path: str, text: str | bytes) -> None:
    """Compare a message of a stream with the schema of its type."""
    where = f"{path.partition('?')[0]}, a message"
    message = orjson.loads(text)
    if path.partition("?")[0] == "/ws" and "type" in message:
        if not isinstance(message.pop("subscription", None), str):
            _note(where, "it does not say to which subscription it belongs")
        text = orjson.dumps(message)
    if path.startswith("/ws/topics"):
        name = "EchoEvent"
    elif "op" in message:
        name = "Answer"
    else:
        of_goal = message.get("type") in ("status", "feedback", "result")
        name = "ActionEvent" if of_goal and not _is_docking(message) else "Event"
    if name == "Answer":
        _compare(where, _reference(name), text)
        return
    kinds = document()["components"]["schemas"][name]["discriminator"]["mapping"]
    if (kind := message.get("type")) not in kinds:
        _note(where, f"its type is {kind!r}, not one of {', '.join(kinds)}")
        return
    _compare(f"{where} of type {kind}", {"$ref": kinds[kind]}, text)


def _is_docking(document: dict[str, Any]) -> bool:
    """Whether a goal, or an event of one, is on a docking or undocking action."""
    return str(document.get("action_name")).rpartition("/")[2] in DOCKING


def _reference(name: str) -> Schema:
    return {"$ref": f"#/components/schemas/{name}"}


def _compare(where: str, schema: Schema, text: str | bytes) -> None:
    try:
        value = orjson.loads(text)
    except orjson.JSONDecodeError as error:
        _note(where, f"it is not JSON: {error}")
        return
    key = orjson.dumps(schema)
    if not _validator(key).is_valid(value):
        _note(where, *_differences(key, value))


def _note(where: str, *differences: str) -> None:
    if len(_noted) < MAX_NOTED:
        _noted.extend(f"{where}: {difference}" for difference in differences)


@cache
def _validator(schema: bytes) -> Draft202012Validator:
    return Draft202012Validator(_whole(schema), validate_formats=True)


def _whole(schema: bytes) -> Schema:
    return {**orjson.loads(schema), "components": document()["components"]}


def _differences(schema: bytes, value: object) -> Iterator[str]:
    """Say what differs. Slower than the check, and clear about alternatives."""
    errors = jsonschema.Draft202012Validator(
        _whole(schema), format_checker=jsonschema.Draft202012Validator.FORMAT_CHECKER
    ).iter_errors(value)
    found = [best for error in errors if (best := jsonschema.exceptions.best_match([error])) is not None]
    for error in found[:5]:
        yield f"{error.json_path}: {error.message[:400]}"
    if not found:  # only the fast library checks this format
        yield str(next(_validator(schema).iter_errors(value)))[:400]


@cache
def _operations() -> list[tuple[int, re.Pattern[str], dict[str, Any]]]:
    """Paths with fewer variables first. Names on the ROS graph contain slashes."""
    found = []
    for template, item in document()["paths"].items():
        pattern = re.sub(r"\\{(name|service|node|topic)\\}", ".+", re.escape(template))
        pattern = pattern.replace(r"robots/\{robot\}", "robots/.*")
        pattern = re.sub(r"\\{\w+\\}", "[^/]+", pattern)
        literals = [part for part in template.split("/") if part and not part.startswith("{")]
        found.append((-len(literals), re.compile(pattern), item))
    return sorted(found, key=lambda entry: entry[0])


def _operation(method: str, path: str) -> dict[str, Any] | None:
    """The operation of a request; None if the path has none of this method.

    The other spellings of a goal's path, and `GET /actions/…/goals`, are answered as what the document has.
    """
    path = SPELLING.sub("/goals", path) if method == "get" or path.endswith("/cancel") else path
    for _, pattern, item in _operations():
        if pattern.fullmatch(path):
            found: dict[str, Any] | None = item.get(method)
            return found
    return None

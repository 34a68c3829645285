"""Read fields that several kinds of requests have: parts of a body, choices, texts, ids that people choose, robots."""

import re
from typing import Any

from fastapi import Path

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.grant import LIMITS, MAX_PATTERN, MAX_PATTERNS, PATTERN, Grant, Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.settings import LONGEST_NAME

MAX_ROBOT = LONGEST_NAME
SLUG = re.compile(r"[a-z0-9](?:[a-z0-9-]{0,38}[a-z0-9])?")
SLUG_IN_PATH = Path(
    description="Lower-case letters, digits and hyphens, up to 40", json_schema_extra={"pattern": f"^{SLUG.pattern}$"}
)
_PATTERNS_REQUEST = {
    "type": "array",
    "maxItems": MAX_PATTERNS,
    "items": {"type": "string", "maxLength": MAX_PATTERN, "pattern": f"^(?:{PATTERN.pattern})$"},
}
GRANT_REQUEST = {
    "role": {"enum": [role.value for role in Role]},
    "robots": _PATTERNS_REQUEST
    | {"description": "Namespaces of robots, in which `*` stands for any text; none means every robot"},
    "actions": _PATTERNS_REQUEST | {"description": "Names of actions, likewise; none means every action of the robots"},
    "topics": _PATTERNS_REQUEST | {"description": "Names of topics, likewise; none means every topic of the robots"},
}


def read_grant(fields: dict[str, Any]) -> Grant:
    """Return a grant from fields as in `GRANT_REQUEST`.

    Raises:
        InvalidField: It is not a grant, or it limits an admin.
    """
    role = str(fields.get("role"))
    read_choice(role, tuple(Role), "role")
    grant = Grant(Role(role), *(_read_patterns(fields.get(name, []), name) for name in LIMITS))
    if grant.role is Role.ADMIN and grant != Grant(Role.ADMIN):
        limits = next(name for name in LIMITS if getattr(grant, name))
        raise InvalidField([FieldError(limits, "none, as an admin can change any limit", got(fields[limits]))])
    return grant


def _read_patterns(value: object, path: str) -> tuple[str, ...]:
    if not isinstance(value, list) or len(value) > MAX_PATTERNS:
        raise InvalidField([FieldError(path, f"an array of up to {MAX_PATTERNS} patterns of names", got(value))])
    for index, pattern in enumerate(value):
        if not isinstance(pattern, str) or len(pattern) > MAX_PATTERN or not PATTERN.fullmatch(pattern):
            raise InvalidField([FieldError(f"{path}.{index}", "a name such as /robot1 or /hall_a/*", got(pattern))])
    return tuple(dict.fromkeys(value))


def read_slug(value: str, path: str) -> str:
    """Return an id that people choose.

    Raises:
        InvalidField: It is not one.
    """
    if not SLUG.fullmatch(value):
        raise InvalidField(
            [FieldError(path, "up to 40 lower-case letters, digits and hyphens between them", got(value))]
        )
    return value


def read_robot(value: object, path: str) -> str:
    """Return the namespace of a robot, which need not be on the ROS graph.

    Raises:
        InvalidField: It is not a namespace.
    """
    if not isinstance(value, str) or len(value) > MAX_ROBOT:
        raise InvalidField([FieldError(path, f"a ROS namespace of up to {MAX_ROBOT} characters", got(value))])
    return read_namespace(value, path)


def read_flag(value: object, path: str) -> bool:
    """Return a boolean.

    Raises:
        InvalidField: It is something else.
    """
    if not isinstance(value, bool):
        raise InvalidField([FieldError(path, "true or false", got(value))])
    return value


def read_choice(value: object, choices: tuple[str, ...], path: str) -> str:
    """Return one of several texts.

    Raises:
        InvalidField: It is something else.
    """
    if not isinstance(value, str) or value not in choices:
        raise InvalidField([FieldError(path, f"one of {', '.join(choices)}", got(value))])
    return value

"""`/interfaces`: the action types in the ament index, and the JSON Schema of their messages."""

from functools import cache
from typing import Annotated, Any

from fastapi import APIRouter, Path

from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.schema import Schema
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import (
    PACKAGE_NAME,
    TYPE_NAME,
    install_hint,
    is_installed,
    known_actions,
    load_action,
)
from dock_gateway.ros.messages.schema import DIALECT

router = APIRouter(route_class=ApiRoute, tags=["Interfaces"], prefix="/interfaces")

Package = Annotated[str, Path(pattern=f"^{PACKAGE_NAME}$", examples=["action_tutorials_interfaces"])]
TypeName = Annotated[str, Path(pattern=f"^{TYPE_NAME}$", examples=["Fibonacci"])]


class Interface(Schema):
    """An action type; `hint` says what to install if its package is missing."""

    type: str
    installed: bool
    hint: str | None
    schema_path: str


class InterfaceList(Schema):
    """The action types in the ament index."""

    interfaces: list[Interface]


class ActionInterface(Schema):
    """JSON Schema (draft 2020-12) of an action's messages.

    `goal` describes what a request may contain; `result` and `feedback` describe what the gateway returns.
    """

    type: str
    goal: dict[str, Any]
    result: dict[str, Any]
    feedback: dict[str, Any]


# Plain functions, which FastAPI runs in threads: they read files and import packages.
@router.get("")
@operation(Role.VIEWER, Scope.ANY)
def list_interfaces() -> Answer[InterfaceList]:
    """List the action types in the ament index. If Python cannot import one, `hint` says what to install."""
    return json_response({"interfaces": [_describe(type_name) for type_name in known_actions()]})


@router.get("/{package}/action/{name}")
@operation(Role.VIEWER, Scope.ANY, errors=(404,))
def get_interface(package: Package, name: TypeName) -> Answer[ActionInterface]:
    """Return the JSON Schema of goal, result and feedback.

    It includes the comments, units, constants and defaults of the definition.
    """
    try:
        return Answer(interface_document(f"{package}/action/{name}"))
    except (ImportError, TypeError) as error:
        raise NotFound(str(error), code="interface_not_found") from None


def _describe(type_name: str) -> dict[str, object]:
    package = type_name.partition("/")[0]
    installed = is_installed(package)
    return {
        "type": type_name,
        "installed": installed,
        "hint": None if installed else install_hint(package),
        "schema_path": f"/interfaces/{type_name}",
    }


@cache  # existing types only: a failure is not cached
def interface_document(type_name: str) -> bytes:
    """Return the JSON Schemas of an action type's messages, as JSON.

    Raises:
        ImportError, TypeError: There is no such type.
    """
    action = load_action(type_name)
    parts = {"goal": (action.Goal, False), "result": (action.Result, True), "feedback": (action.Feedback, True)}
    return encode(
        {"type": type_name}
        | {
            part: {"$schema": DIALECT, **codec(message_class).schema(complete=complete)}
            for part, (message_class, complete) in parts.items()
        }
    )

"""The OpenAPI document: FastAPI's, plus the schemas of stream events and of what else no route names."""

import asyncio
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import orjson
from fastapi import FastAPI, Response
from fastapi.openapi.utils import get_openapi
from fastapi.routing import iter_route_contexts
from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from dock_gateway.core.error_codes import ErrorCode
from dock_gateway.http.operation import Operation, Scope, find_operation
from dock_gateway.http.requests import X_ROBOT

SECURITY_SCHEMES = {
    "token": {"type": "http", "scheme": "bearer", "description": "A token, where the gateway asks for logins"},
    "login": {"type": "apiKey", "in": "cookie", "name": "dock-gateway", "description": "The dashboard's login"},
}
COMPONENTS = "#/components/schemas/"
NO_LOGIN: dict[str, list[str]] = {}
REF = f"{COMPONENTS}{{model}}"


Models = Sequence[type[BaseModel]]
NO_VALUES: Mapping[str, Sequence[str]] = {}
NO_FIELDS: Mapping[str, Mapping[str, type[BaseModel]]] = {}


@dataclass(frozen=True)
class Union:
    """A component of the document that is one of several models.

    Attributes:
        name: The name of the component.
        models: The models.
        description: What they are.
        discriminator: The field that tells them apart, if one does.
        mode: Whether the gateway sends them (`serialization`) or reads them (`validation`).
        operations: The requirements of each, by its value of the discriminator, if they are commands.
    """

    name: str
    models: Models
    description: str
    discriminator: str | None = "type"
    mode: JsonSchemaMode = "serialization"
    operations: Mapping[str, Operation] = field(default_factory=dict)


def install_openapi(
    app: FastAPI,
    *,
    authentication: bool,
    unions: Iterable[Union],
    models: Models,
    messages: Callable[[], dict[str, Any]] = dict,
    values: Mapping[str, Sequence[str]] = NO_VALUES,
    codes: Sequence[ErrorCode] = (),
    fields: Mapping[str, Mapping[str, type[BaseModel]]] = NO_FIELDS,
) -> None:
    """Make the app serve its OpenAPI document with our schemas in it.

    Args:
        app: The application.
        authentication: Whether requests need a token.
        unions: The messages of streams, which no route names.
        models: Further models that no route names.
        messages: Returns the schemas of ROS messages, by name.
        values: Further values of enumerations, by the name of the component.
        codes: All error codes: `x-codes` of the schema `Problem`.
        fields: Further fields of components, by the name of the component: the model of each, which may be null.
    """
    models = [*models, *(model for added in fields.values() for model in added.values())]
    components = [*unions]

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = _build(app, components, models, messages, authentication=authentication)
            for name, further in values.items():
                document["components"]["schemas"][name]["enum"] += further
            document["components"]["schemas"]["Problem"]["x-codes"] = [code.document() for code in codes]
            for name, added in fields.items():
                _add_fields(document["components"]["schemas"][name], added)
            app.openapi_schema = document
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]

    serve_document(app, "/openapi.json", openapi)


def serve_document(app: FastAPI, path: str, build: Callable[[], dict[str, Any]]) -> None:
    """Serve a document that is built when it is first asked for."""
    made: list[bytes] = []
    making = asyncio.Lock()

    @app.get(path, include_in_schema=False)
    async def document() -> Response:
        """Return the document. Building it takes 0.2 s, in a thread so that a stop does not wait."""
        async with making:
            if not made:
                made.append(await asyncio.to_thread(lambda: orjson.dumps(build())))
        return Response(made[0], media_type="application/json")


def _build(
    app: FastAPI,
    unions: list[Union],
    further: Models,
    messages: Callable[[], dict[str, Any]],
    *,
    authentication: bool,
) -> dict[str, Any]:
    document = get_openapi(
        title=app.title,
        version=app.version,
        description=app.description,
        routes=app.routes,
        tags=app.openapi_tags,
    )
    components = document.setdefault("components", {})
    components["securitySchemes"] = SECURITY_SCHEMES
    document["security"] = [*([] if authentication else [NO_LOGIN]), *({name: []} for name in SECURITY_SCHEMES)]
    _add_roles(document, app)
    schemas = components.setdefault("schemas", {})
    modes: list[tuple[type[BaseModel], JsonSchemaMode]] = [
        *((model, union.mode) for union in unions for model in union.models),
        *((model, "serialization") for model in further),
    ]
    _, ours = models_json_schema(modes, ref_template=REF)
    schemas.update(ours["$defs"])
    for union in unions:
        schemas[union.name] = _one_of(schemas, union)
    schemas.update(messages())
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    document["components"]["schemas"] = dict(sorted(schemas.items()))
    _open_answers(document, unions)
    return document


def _add_fields(schema: dict[str, Any], fields: Mapping[str, type[BaseModel]]) -> None:
    for name, model in fields.items():
        schema["properties"][name] = {"anyOf": [{"$ref": REF.format(model=model.__name__)}, {"type": "null"}]}
        schema["required"].append(name)


def _open_answers(document: dict[str, Any], unions: Iterable[Union]) -> None:
    """Let the schemas of answers have further fields, and leave those of requests as they are."""
    schemas = document["components"]["schemas"]
    operations = [operation for item in document["paths"].values() for operation in item.values()]
    read = [name for union in unions if union.mode == "validation" for name in references(schemas[union.name])]
    for operation in operations:
        read += references([operation.get("requestBody"), operation.get("parameters")])
    closed = reachable(read, schemas)
    _open([operation["responses"] for operation in operations])
    _open([schema for name, schema in schemas.items() if name not in closed])


def _open(value: Any) -> None:
    """Let every object of these schemas have further fields."""
    if isinstance(value, dict):
        if value.get("additionalProperties") is False:
            del value["additionalProperties"]
        value = [*value.values()]
    if isinstance(value, list):
        for item in value:
            _open(item)


def reachable(names: Iterable[str], schemas: Mapping[str, Any]) -> set[str]:
    """Return the names of these components and of all that they refer to."""
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += references(schemas[name])
    return found


def references(value: object) -> Iterator[str]:
    """Yield the name of each component that a part of the document refers to."""
    if isinstance(value, dict):
        if isinstance(target := value.get("$ref"), str):
            yield target.removeprefix(COMPONENTS)
        value = [*value.values()]
    if isinstance(value, list):
        for item in value:
            yield from references(item)


def _add_roles(document: dict[str, Any], app: FastAPI) -> None:
    """Add to each operation the role that it needs, as `x-role`; or that it needs none.

    `x-every-robot` is true where it is about every robot: access that is limited to some does not suffice.
    """
    for route in iter_route_contexts(app.routes):
        operations = document["paths"].get(str(route.path_format), {})
        for operation in (operations.get(method.lower()) for method in route.methods or ()):
            if operation is None:
                continue
            if "HTTPValidationError" in str(operation["responses"].get("422")):  # FastAPI's own, which is never sent
                del operation["responses"]["422"]
            for parameter in operation.get("parameters", ()):
                if (meaning := parameter["schema"].pop(X_ROBOT, None)) is not None:
                    operation[X_ROBOT] = meaning
            needed = find_operation(route)
            if needed is not None and needed.role is not None:
                operation.update(_needs(needed))
            else:
                operation["security"] = []


def _needs(operation: Operation) -> dict[str, Any]:
    every_robot = {"x-every-robot": True} if operation.scope is Scope.EVERY else {}
    return {"x-role": operation.role, **every_robot}


def _one_of(schemas: dict[str, Any], union: Union) -> dict[str, Any]:
    """Return the schema of a union. Each of its models that is a command gets the role that it needs."""
    references = [{"$ref": REF.format(model=model.__name__)} for model in union.models]
    if union.discriminator is None:
        return {"description": union.description, "anyOf": references}
    kinds = [schemas[model.__name__]["properties"][union.discriminator]["const"] for model in union.models]
    for kind, model in zip(kinds, union.models, strict=True):
        if kind in union.operations:
            schemas[model.__name__] |= _needs(union.operations[kind])
    mapping = {kind: reference["$ref"] for kind, reference in zip(kinds, references, strict=True)}
    return {
        "description": union.description,
        "oneOf": references,
        "discriminator": {"propertyName": union.discriminator, "mapping": mapping},
    }


# `openapi_extra` of an operation that may change with a minor version: docs/compatibility.md.
UNSTABLE: dict[str, Any] = {"x-stability": "unstable"}
# A parameter of operations that `read_key` reads.
IDEMPOTENCY_KEY: dict[str, Any] = {
    "name": "Idempotency-Key",
    "in": "header",
    "schema": {"type": "string", "minLength": 1, "maxLength": 200},
}
BATTERY_INPUT: dict[str, Any] = {"$ref": "#/components/schemas/BatteryStateInput"}


def battery_body(*, required: bool) -> dict[str, Any]:
    """Return the `openapi_extra` of a request whose body is read by the gateway, not by FastAPI."""
    return body(BATTERY_INPUT, required=required)


def docking_body(*texts: str) -> dict[str, Any]:
    """Return the `openapi_extra` of a request to dock or undock; `texts` are the names of its further fields."""
    properties = {
        "desired_battery_state": BATTERY_INPUT,
        **{name: {"type": "string", "pattern": "\\S"} for name in texts},
    }
    return body({"type": "object", "additionalProperties": True, "properties": properties}, required=False)


def body(schema: dict[str, Any], *, required: bool) -> dict[str, Any]:
    """Like `battery_body`, for any schema."""
    return {"requestBody": {"required": required, "content": {"application/json": {"schema": schema}}}}

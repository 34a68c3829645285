"""The AsyncAPI document: the streams and the commands of `/ws`, with the schemas of the OpenAPI document.

The channels of Server-Sent Events are the operations of the OpenAPI document that answer with them.
"""

from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import BaseModel

from dock_gateway.goals.schema import ACTION_EVENTS
from dock_gateway.http.openapi import COMPONENTS, NO_LOGIN, reachable
from dock_gateway.http.operation import operation_of
from dock_gateway.http.principal import TICKET
from dock_gateway.streams import events, socket, topics
from dock_gateway.streams.command_schema import ANSWERS, ANSWERS_TO, COMMAND_SCHEMAS, CommandError
from dock_gateway.streams.schema import EVENTS, GOAL_EVENTS
from dock_gateway.streams.topic_schema import ECHO_EVENTS

Json = dict[str, Any]
Models = tuple[type[BaseModel], ...]

SSE = "text/event-stream"
EVENTS_OF_GOAL: Models = (*GOAL_EVENTS, *ACTION_EVENTS)
SERVERS = {
    "websockets": {"protocol": "ws", "description": "WebSockets; `wss` where the gateway has TLS"},
    "http": {"protocol": "http", "description": "Server-Sent Events; `https` where the gateway has TLS"},
}
ADDRESS = {"default": "127.0.0.1:8000", "description": "Host and port of the gateway"}
TOPIC_QUERY: Json = {
    "topic": {"type": "string", "description": "The name of a topic on the ROS graph"},
    "max_rate": {"type": "number", "minimum": topics.MIN_RATE, "maximum": topics.MAX_RATE},
}
TICKET_SCHEME: Json = {
    "type": "httpApiKey",
    "in": "query",
    "name": TICKET,
    "description": "For a WebSocket of a page of another origin: a ticket of POST /session/ticket",
}


def asyncapi_document(openapi: Json, further: Models) -> Json:
    """Return the AsyncAPI 3.0 document that belongs to an OpenAPI document of this gateway.

    Args:
        openapi: The OpenAPI document.
        further: The events of extensions.
    """
    all_events: Models = (*EVENTS, *further, *ACTION_EVENTS)
    schemas: Json = openapi["components"]["schemas"]
    stream_query = {
        name: field for name, field in schemas["SubscribeCommand"]["properties"].items() if name not in ("op", "id")
    }
    commands: Models = (*COMMAND_SCHEMAS, *ANSWERS)
    channels = {
        "socket": _socket("/ws", socket.socket, (*commands, *all_events), {}),
        "feedback": _socket("/ws/feedback", events.feedback, all_events, stream_query),
        "topics": _socket("/ws/topics", topics.echo_topic, ECHO_EVENTS, TOPIC_QUERY, required=["topic"]),
    }
    operations = {
        "socket_events": _sent("socket", events.feedback, all_events),
        "feedback": _sent("feedback", events.feedback, all_events),
        "topics": _sent("topics", topics.echo_topic, ECHO_EVENTS),
        **dict(_commands(schemas)),
    }
    query = {name: stream_query[name] for name in ("feedback", "after", "max_rate")}
    for path, operation in _server_sent(openapi):
        name = operation["operationId"]
        channels[name] = _goal_channel(path, operation)
        operations[name] = {
            "action": "send",
            "channel": {"$ref": f"#/channels/{name}"},
            "messages": _of_channel(name, EVENTS_OF_GOAL),
            "bindings": {"http": {"method": "GET", "query": _object(query), "bindingVersion": "0.3.0"}},
            "x-role": operation["x-role"],
        }
    messages = [*dict.fromkeys(model.__name__ for model in (*commands, *all_events, *ECHO_EVENTS))]
    schemes = {name: _scheme(scheme) for name, scheme in openapi["components"]["securitySchemes"].items()}
    required = NO_LOGIN not in openapi["security"]
    servers = {
        "websockets": _server(SERVERS["websockets"], [*schemes, TICKET] if required else []),
        "http": _server(SERVERS["http"], schemes if required else []),
    }
    return {
        "asyncapi": "3.0.0",
        "info": {name: openapi["info"][name] for name in ("title", "version", "description")},
        "defaultContentType": "application/json",
        "servers": servers,
        "channels": channels,
        "operations": operations,
        "components": {
            "messages": {name: _message(name, schemas[name]) for name in messages},
            "schemas": {name: schemas[name] for name in sorted(reachable(messages, schemas))},
            "securitySchemes": schemes | {TICKET: TICKET_SCHEME},
        },
    }


def _server(server: Json, schemes: Iterable[str]) -> Json:
    security = [{"$ref": f"#/components/securitySchemes/{name}"} for name in schemes]
    return {"host": "{address}", "variables": {"address": ADDRESS}, **server, "security": security}


def _socket(path: str, endpoint: Any, models: Models, query: Json, *, required: Iterable[str] = ()) -> Json:
    query = query | {TICKET: {"type": "string"}}
    return {
        "address": path,
        "description": endpoint.__doc__.partition("\n")[0],
        "servers": [{"$ref": "#/servers/websockets"}],
        "messages": _of_components(models),
        "bindings": {"ws": {"method": "GET", "query": _object(query, required), "bindingVersion": "0.1.0"}},
    }


def _goal_channel(path: str, operation: Json) -> Json:
    return {
        "address": path,
        "description": f"{operation['description']} Each event is the `data` of a Server-Sent Event with its id.",
        "servers": [{"$ref": "#/servers/http"}],
        "parameters": {
            parameter["name"]: {"description": parameter.get("description", "The id of a goal")}
            for parameter in operation["parameters"]
            if parameter["in"] == "path"
        },
        "messages": _of_components(EVENTS_OF_GOAL),
    }


def _server_sent(openapi: Json) -> Iterator[tuple[str, Json]]:
    """Yield the path and the operation of each stream of Server-Sent Events."""
    for path, item in openapi["paths"].items():
        if "get" in item and SSE in item["get"]["responses"].get("200", {}).get("content", {}):
            yield path, item["get"]


def _sent(channel: str, endpoint: object, models: Models) -> Json:
    return {
        "action": "send",
        "channel": {"$ref": f"#/channels/{channel}"},
        "messages": _of_channel(channel, models),
        "x-role": operation_of(endpoint).role,
    }


def _commands(schemas: Json) -> Iterator[tuple[str, Json]]:
    channel = {"$ref": "#/channels/socket"}
    for model in COMMAND_SCHEMAS:
        schema = schemas[model.__name__]
        op = schema["properties"]["op"]["const"]
        yield (
            op,
            {
                "action": "receive",
                "channel": channel,
                "messages": _of_channel("socket", (model,)),
                "reply": {"channel": channel, "messages": _of_channel("socket", (*ANSWERS_TO[op], CommandError))},
                "x-role": schema["x-role"],
            },
        )


def _message(name: str, schema: Json) -> Json:
    properties = schema["properties"]
    kind = properties.get("op") or properties["type"]
    correlation = {"correlationId": {"location": "$message.payload#/id"}} if "op" in properties else {}
    return {
        "name": kind["const"],
        "summary": schema["description"].partition("\n")[0],
        "payload": {"$ref": f"{COMPONENTS}{name}"},
        **correlation,
    }


def _scheme(scheme: Json) -> Json:
    """Return a security scheme of OpenAPI as one of AsyncAPI."""
    return scheme | {"type": "httpApiKey"} if scheme["type"] == "apiKey" else scheme


def _of_components(models: Models) -> Json:
    return {model.__name__: {"$ref": f"#/components/messages/{model.__name__}"} for model in models}


def _of_channel(channel: str, models: Models) -> list[Json]:
    return [{"$ref": f"#/channels/{channel}/messages/{model.__name__}"} for model in models]


def _object(properties: Json, required: Iterable[str] = ()) -> Json:
    return {"type": "object", "properties": properties, "required": list(required), "additionalProperties": False}

"""`/topics`: what is published on any topic of the ROS graph, and messages on those that the settings name."""

from typing import Any

from fastapi import APIRouter, Request

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import fragment
from dock_gateway.core.grant import Role
from dock_gateway.doors.rest.service_routes import TypeQuery, describe_use, message_schema
from dock_gateway.graph.call_schema import PublishedMessage, TopicInfo
from dock_gateway.graph.publishing import Publishing
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import TheGrant, ThePrincipal
from dock_gateway.http.requests import Answer, GraphName, json_response, read_body, read_json
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations.topics import Publish, publish

router = APIRouter(route_class=ApiRoute, tags=["Topics"], prefix="/topics")


@router.get("/{topic:graph_name}")
@operation(Role.VIEWER, Scope.TOPIC)
async def get_topic_message(
    topic: GraphName, publishing: Part[Publishing], grant: TheGrant, *, type_name: TypeQuery = None
) -> Answer[TopicInfo]:
    """Return the type of a topic, the JSON Schema of its messages, and whether it may be published on."""
    found = await publishing.find(f"/{topic}", type_name, grant)
    document: dict[str, Any] = {
        "topic": found.name,
        "type": found.type,
        "types": found.types,
        "reports": found.reports,
        "hint": None,
        "publish": describe_use(lambda: publishing.require_allowed(found.name)),
        "message": None,
    }
    try:
        document["message"] = message_schema(await publishing.load(found), complete=False)
    except GatewayError as error:
        document["hint"] = error.detail
    return json_response(document)


@router.post(
    "/{topic:graph_name}",
    openapi_extra=body({"type": "object", "description": "The message's own fields"}, required=True),
)
@carries_out(publish)
async def publish_message(
    topic: GraphName,
    request: Request,
    parts: AllParts,
    principal: ThePrincipal,
    *,
    type_name: TypeQuery = None,
) -> Answer[PublishedMessage]:
    """Publish one message on a topic. The body holds the fields of the message; `{}` publishes its defaults.

    `type` is needed only on a topic where no one is yet, or one with several types.
    """
    name = f"/{topic}"
    fields = await read_json(request)
    published = await publish(parts, principal, Publish(name, fields, type_name))
    message = await published.encode(len(await read_body(request)))
    return json_response(
        {
            "topic": name,
            "type": published.type,
            "subscribers": published.subscribers,
            "message": fragment(message),
        }
    )

"""Services that a client calls: the gateway's own, those of `/rosapi`, and those of ROS nodes by permission."""

from typing import Any

import orjson

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.core.graph import GraphScan
from dock_gateway.core.json_text import decode_json
from dock_gateway.extensions.rosbridge import rosapi
from dock_gateway.extensions.rosbridge.protocol import CallService
from dock_gateway.extensions.rosbridge.values import adapter
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.operations import services as operations
from dock_gateway.streams.commands import OWN_SERVICES
from dock_gateway.streams.node_parameters import NodeParameters
from dock_gateway.streams.rights import Rights

Json = dict[str, Any]


class RosbridgeServices:
    """Calls services for one client.

    Args:
        parts: Carry out the calls.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
        self._rights = rights
        self._parameters = NodeParameters(parts, rights)
        self._of_parameters = {
            "get_param": self._get_param,
            "has_param": self._has_param,
            "set_param": self._set_param,
            "get_param_names": self._get_param_names,
        }

    async def call(self, service: str, request: CallService) -> Any:
        """Call a service, and return its response.

        Args:
            service: Absolute name.
            request: The operation.

        Raises:
            GatewayError: It may not be called, or failed.
        """
        args = request.args
        if service in OWN_SERVICES:
            if not isinstance(args, dict) and args not in (None, []):
                raise InvalidField([FieldError("args", "an object", "got something else")])
            return await self._rights.command(OWN_SERVICES[service], args or {})
        if not service.startswith(rosapi.PREFIX):
            return await self.call_service(service, request)
        parameter = self._of_parameters.get(service.removeprefix(rosapi.PREFIX))
        if parameter is not None:
            return await parameter(args)
        return await self.ask(service, args)

    async def call_service(self, service: str, request: CallService) -> Any:
        """Call a service of a ROS node."""

        async def call() -> Any:
            services = self._parts[ServiceCalls]
            fields = {} if request.args in (None, []) else request.args
            if isinstance(fields, list):  # its fields in order
                found = await services.find(service, grant=self._rights.grant)
                kind = await services.load(found)
                fields = dict(zip(kind.Request.get_fields_and_field_types(), fields, strict=False))
            order = operations.CallService(service, fields, timeout=request.timeout)
            answer = await operations.call_service(self._parts, self._rights.principal, order)
            adapt = adapter(answer.kind.Response)
            response = orjson.loads(await services.encode(service, answer))
            return response if adapt is None else adapt(response)

        return await self._rights.perform(operations.call_service, {"service": service}, call)

    @operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
    async def ask(self, service: str, args: Any) -> Json:
        """Ask a service of `/rosapi`."""
        await self._rights.require(RosbridgeServices.ask, {})
        return await rosapi.answer(self._parts, self._rights.grant, service, args)

    async def _value(self, args: Any) -> Any:
        """Return the value of a parameter, None if the node has no such parameter."""
        node, name = _parameter(args)
        parameters = await self._parameters.get(node)
        return next((each.document()["value"] for each in parameters if each.name == name), None)

    async def _get_param(self, args: Any) -> Json:
        value = await self._value(args)
        default = args.get("default_value", args.get("default", "")) if isinstance(args, dict) else ""
        return {"value": default if value is None else encode(value).decode(), "successful": value is not None}

    async def _has_param(self, args: Any) -> Json:
        return {"exists": await self._value(args) is not None}

    async def _set_param(self, args: Any) -> Json:
        node, name = _parameter(args)
        text = args.get("value")
        value = decode_json(text, "args.value", constants=True) if isinstance(text, str) else text
        await self._parameters.set_param(node, {name: value})
        return {"successful": True, "reason": ""}

    async def _get_param_names(self, _: Any) -> Json:
        seen: GraphScan = (await self._parts[GraphCache].graph(self._rights.grant)).seen
        found = await self._parameters.get_all(seen.nodes)
        return {"names": sorted(f"{node}:{each.name}" for node, parameters in found.items() for each in parameters)}


def _parameter(args: Any) -> tuple[str, str]:
    """Return the node and the name of a parameter, which a client writes as `/node:name`."""
    text = args.get("name") if isinstance(args, dict) else None
    node, separator, name = text.partition(":") if isinstance(text, str) else ("", "", "")
    if not (separator and node.strip("/") and name):
        raise InvalidField(
            [FieldError("args.name", "a node and a parameter, such as /node:name", "got something else")]
        )
    return f"/{node.lstrip('/')}", name

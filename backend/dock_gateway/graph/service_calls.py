"""Calls any service on the ROS graph that the setting `allow_services` allows.

A service may do anything, also move a robot past goals and the latch. So none is called that the setting does not
name, except those that only read; and none of a stopped robot, except those.
"""

import asyncio
from collections import Counter, OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from dock_gateway.core.allow_list import AllowList
from dock_gateway.core.errors import GatewayError, ServerTimeout, use_other_request
from dock_gateway.core.goal import Json
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.graph import ACTION_PART
from dock_gateway.core.request import act, slot
from dock_gateway.graph.names import choose_type, not_found, not_installed
from dock_gateway.latch.interlock import Interlock
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import TOPIC_NAME, read_service, service_names
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_service
from dock_gateway.ros.service_client import ServiceClient
from dock_gateway.setting_types import LONGEST_NAME
from dock_gateway.settings import Settings

# Clients that are kept for the next call.
MAX_CLIENTS = 50
# Seconds between two checks for a service that is not there yet.
CHECK_INTERVAL = 0.25

# Services that only read. They say nothing of what a robot does, so everyone who may call services may call these.
READING = frozenset(
    {
        "lifecycle_msgs/srv/GetAvailableStates",
        "lifecycle_msgs/srv/GetAvailableTransitions",
        "lifecycle_msgs/srv/GetState",
        "rcl_interfaces/srv/DescribeParameters",
        "rcl_interfaces/srv/GetLoggerLevels",
        "rcl_interfaces/srv/GetParameterTypes",
        "rcl_interfaces/srv/GetParameters",
        "rcl_interfaces/srv/ListParameters",
        "type_description_interfaces/srv/GetTypeDescription",
    }
)
# Services that set parameters, which needs the role and the setting for that.
SETTING = frozenset({"rcl_interfaces/srv/SetParameters", "rcl_interfaces/srv/SetParametersAtomically"})


@dataclass(frozen=True)
class FoundService:
    """A service on the graph.

    Attributes:
        name: Absolute name.
        type: The type that is called.
        types: All types that its servers have; more than one is a mistake on the graph.
    """

    name: str
    type: str
    types: tuple[str, ...]

    @property
    def reads(self) -> bool:
        """Whether it only reads."""
        return READING.issuperset(self.types)


@dataclass(frozen=True)
class ServiceResponse:
    """The response of a service as a message, with its type and that type's class."""

    type: str
    kind: Any
    response: Any


class ServiceCalls:
    """Calls services. Who uses it has checked that the user's grant covers the name (`Grant.covers_service`).

    Args:
        settings: Which services may be called.
        bridge: The bridge to the ROS thread.
        interlock: Which robots are stopped.

    Attributes:
        listed: The services that may be called.
    """

    def __init__(self, settings: Settings, bridge: Bridge, interlock: Interlock) -> None:
        self._wait = settings.server_wait
        self._find_within = settings.accept_timeout
        self._bridge = bridge
        self._interlock = interlock
        self.listed = AllowList("allow_services", settings.allow_services, "the gateway does not call the service")
        self._clients: OrderedDict[tuple[str, str], ServiceClient] = OrderedDict()
        self._running: Counter[str] = Counter()

    async def find(self, name: str, type_name: str | None = None, grant: Grant = UNLIMITED) -> FoundService:
        """Return a service, waiting for it to appear.

        Args:
            name: Absolute name.
            type_name: Its type, if it has several.
            grant: What the user may see of the graph.

        Raises:
            NotFound: `service_not_found`, with similar names.
            InvalidField: `type_name` is not a type that it has, or it is missing and needed.
            Unavailable: `ros_unavailable`.
        """
        loop = asyncio.get_running_loop()
        until = loop.time() + (self._wait if TOPIC_NAME.fullmatch(name) and len(name) <= LONGEST_NAME else 0)
        while not (types := await self._bridge.call(lambda: read_service(self._bridge.node, name))):
            if loop.time() >= until:
                known = await self._bridge.call(lambda: service_names(self._bridge.node))
                raise not_found("service", name, filter(grant.covers_place, known))
            await asyncio.sleep(CHECK_INTERVAL)
        return FoundService(name, choose_type(name, types, type_name), tuple(types))

    def require_allowed(self, service: FoundService) -> None:
        """Refuse a service that may not be called.

        Raises:
            NotAllowed: It is not in the setting (`not_allowed`), or is called in another way (`use_other_request`).
        """
        if ACTION_PART in service.name:
            action = service.name.partition(ACTION_PART)[0]
            raise use_other_request(
                f"{service.name[:200]} is a part of the action {action[:200]}, whose goals a stop must find",
                f"POST /actions{action[:200]}/goals",
            )
        if not SETTING.isdisjoint(service.types):
            node = service.name.rpartition("/")[0]
            raise use_other_request(f"{service.name[:200]} sets parameters", f"PATCH /nodes{node[:200]}/parameters")
        if not service.reads:
            self.listed.require(service.name)

    async def call(
        self,
        name: str,
        fields: object,
        *,
        type_name: str | None = None,
        timeout: float = 5.0,
        grant: Grant = UNLIMITED,
    ) -> ServiceResponse:
        """Call a service and return its response as a message. Nothing is sent unless the request is valid.

        Args:
            name: Absolute name.
            fields: The request, as decoded JSON or as a message.
            type_name: The type of the service, if it has several.
            timeout: Seconds to wait for the response, after the service has been found.
            grant: What the user may see of the graph.

        Raises:
            NotFound, InvalidField: As for `find`; or `fields` are not a request of this type.
            NotAllowed: As for `require_allowed`.
            Conflict: `stop_latched`: the robot is stopped.
            TooManyRequests: `too_many_calls`.
            NotInstalled: The package of its type is missing.
            Unavailable: It is not reached (`service_unavailable`) or has left (`service_gone`), or `ros_unavailable`.
            ServerTimeout: `service_timeout`: it did not answer. It may have carried out the call.
        """
        service = await self.find(name, type_name, grant)
        self.require_allowed(service)
        kind = await self.load(service)
        request = await codec(kind.Request).read(fields)
        self._require_released(service)

        def before() -> None:
            act()
            self._require_released(service)

        with slot("calls"), slot("calls of one", per=name), self._counted(name):
            client = self._client(service, kind)
            try:
                response = await client.ask(request, timeout, before)
            except TimeoutError:
                raise ServerTimeout(
                    f"{name} did not answer within {timeout:g} s; it may still carry out the call",
                    code="service_timeout",
                ) from None
        return ServiceResponse(service.type, kind, response)

    @staticmethod
    async def load(service: FoundService) -> Any:
        """Return the Python class of a service's type.

        Raises:
            NotInstalled: The package of its type is missing.
        """

        def load() -> Any:
            kind = load_service(service.type)
            codec(kind.Request), codec(kind.Response)
            return kind

        try:
            return await asyncio.to_thread(load)
        except (ImportError, TypeError) as error:
            raise not_installed(service.name, service.type, error) from None

    def _require_released(self, service: FoundService) -> None:
        if not service.reads:
            self._interlock.require_released(service.name, "calls of its services")

    @contextmanager
    def _counted(self, name: str) -> Iterator[None]:
        """Count a call while the block runs."""
        self._running[name] += 1
        try:
            yield
        finally:
            self._running[name] -= 1
            if not self._running[name]:
                del self._running[name]

    def _client(self, service: FoundService, kind: Any) -> ServiceClient:
        """Return a client, kept from an earlier call or new. One participant has one type for each service."""
        key = service.name, service.type
        for other in [each for each in self._clients if each[0] == service.name and each != key]:
            self._clients.pop(other).close()
        client = self._clients.setdefault(key, ServiceClient(self._bridge, kind, service.name, self._find_within))
        self._clients.move_to_end(key)
        while len(self._clients) > MAX_CLIENTS:
            oldest = next((each for each in self._clients if each[0] not in self._running), None)
            if oldest is None:
                break
            self._clients.pop(oldest).close()
        return client

    async def encode(self, name: str, answer: ServiceResponse) -> Json:
        """Return the response of a service as JSON.

        Raises:
            GatewayError: `response_too_large`.
        """
        encoded = await asyncio.to_thread(codec(answer.kind.Response).encode, answer.response)
        if len(encoded) > self._bridge.max_message_bytes:
            raise GatewayError(
                f"the response of {name} has {len(encoded)} bytes, more than max_message_bytes",
                code="response_too_large",
                status=HTTPStatus.BAD_GATEWAY,
            )
        return encoded

    async def close(self) -> None:
        """Leave all services."""
        while self._clients:
            self._clients.popitem()[1].close()

"""The services that one client may call: actions, those of ROS nodes by permission, and the gateway's own."""

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from itertools import islice
from typing import Any

from dock_gateway.core.errors import GatewayError, NotAllowed, NotFound
from dock_gateway.core.filters import is_hidden
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.core.graph import ACTION_PART, GraphScan, is_noise
from dock_gateway.extensions.foxglove.action_calls import ActionCalls
from dock_gateway.extensions.foxglove.channels import unused_id
from dock_gateway.extensions.foxglove.forms import Form, MessageForm, ResultForm, TextForm, form_document, read_form
from dock_gateway.extensions.foxglove.protocol import Call, Json
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.service_calls import FoundService, ServiceCalls
from dock_gateway.http.parts import Parts
from dock_gateway.operations import services as operations
from dock_gateway.ros.messages.interfaces import load_action, load_service
from dock_gateway.settings import Settings
from dock_gateway.stop.order import STOP_SERVICE
from dock_gateway.streams.commands import OWN_SERVICES, STOP
from dock_gateway.streams.rights import Rights

# Services of nodes that a client is offered.
MAX_SERVICES = 5000
# Seconds that a service of a ROS node may take: a client cannot say.
TIMEOUT = 30.0

GOAL_ID = ("goal_id",)
# Name and type.
Key = tuple[str, str]
Forms = tuple[Form, Form]
Carry = Callable[[Any], Awaitable[Any]]


@dataclass(frozen=True)
class Draft:
    """A service that is not offered yet.

    Attributes:
        forms: Finds the forms of requests and responses, which may take long.
        call: Carries out a call, given the request. Returns the response.
        urgent: Whether it stops something.
        reads: Whether it only reads, and may take minutes.
    """

    forms: Callable[[], Forms]
    call: Carry
    urgent: bool = False
    reads: bool = False


@dataclass(frozen=True)
class Service:
    """A service as a client is offered it."""

    id: int
    name: str
    type: str
    request: Form
    response: Form
    draft: Draft

    def document(self) -> Json:
        """Return the service as it is advertised."""
        return {
            "id": self.id,
            "name": self.name,
            "type": self.type,
            "request": form_document(self.request),
            "response": form_document(self.response),
        }


class FoxgloveServices:
    """The services of one client.

    Args:
        parts: Carry out the calls.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
        self._rights = rights
        self._actions = ActionCalls(parts, rights)
        self._services: dict[int, Service] = {}
        self._unusable: set[Key] = set()
        self._known: tuple[GraphScan, list[Key]] | None = None  # the graph and the actions at the last update

    def find(self, identity: int) -> Service | None:
        """Return a service by its id."""
        return self._services.get(identity)

    async def call(self, call: Call) -> bytes:
        """Call a service, and return its response.

        Raises:
            GatewayError: There is no such service, it may not be called, or the call failed.
        """
        service = self._services.get(call.service)
        if service is None:
            raise NotFound(f"there is no service {call.service}", code="service_not_found")
        try:
            form, encoding = service.request, call.encoding
            # What stops something does not wait.
            urgent = service.draft.urgent
            request = form.read(encoding, call.request) if urgent else await read_form(form, encoding, call.request)
        except GatewayError as error:
            if service.name != STOP_SERVICE:  # a stop is carried out anyway
                raise
            request = error
        response = service.response.write(call.encoding, await service.draft.call(request))
        if len(response) > self._parts[Settings].max_message_bytes:
            detail = f"the response of {service.name} has {len(response)} bytes, more than max_message_bytes"
            raise GatewayError(detail, code="response_too_large", status=HTTPStatus.BAD_GATEWAY)
        return response

    async def update(self, seen: GraphScan) -> tuple[list[Service], list[Service]]:
        """Follow the graph; return the services that are new, and those that are gone."""
        actions = self._usable_actions()
        if self._known is not None and self._known[0] is seen and self._known[1] == actions:
            return [], []
        known = {(each.name, each.type): each for each in self._services.values()}
        wanted = await asyncio.to_thread(self._find, seen, actions)
        self._known = seen, actions
        self._unusable &= wanted.keys()
        missing = {key: draft for key, draft in wanted.items() if key not in known and key not in self._unusable}
        forms = await asyncio.to_thread(_find_forms, missing) if missing else {}
        gone = [each for key, each in known.items() if key not in wanted]
        for service in gone:
            del self._services[service.id]
        for (name, kind), (request, response) in forms.items():
            draft, identity = missing[name, kind], unused_id(f"{name} {kind}", self._services)
            self._services[identity] = Service(identity, name, kind, request, response, draft)
        self._unusable |= missing.keys() - forms.keys()
        return [each for each in self._services.values() if (each.name, each.type) not in known], gone

    def _usable_actions(self) -> list[Key]:
        """Return the actions that have a server and are not hidden, with their types."""
        return [
            (action.name, action.type)
            for action in self._parts[ActionRegistry].all()
            if action.watch.state.available and (action.verb is not None or not is_hidden(action.name))
        ]

    def _of_gateway(self, actions: Iterable[Key]) -> Iterator[tuple[Key, Draft]]:
        """Yield the gateway's own services, and those of the actions that the user may use."""
        role = self._rights.grant.role
        for name, command in OWN_SERVICES.items():
            if command == STOP or role.includes(Role.SUPERVISOR):
                yield self._own(name, command)
        for name, kind in actions:
            if self._rights.grant.covers_action(name):
                yield from self._of_action(name, kind)

    def _own(self, name: str, command: str) -> tuple[Key, Draft]:
        async def call(request: Json) -> Json:
            return {"report": encode(await self._rights.command(command, request)).decode()}

        kind = f"dock_gateway/srv/{command.title().replace('_', '')}"
        forms = TextForm(f"{kind}_Request", ("robot",)), TextForm(f"{kind}_Response", ("report",))
        return (name, kind), Draft(lambda: forms, call, urgent=command == STOP)

    def _of_action(self, name: str, kind: str) -> Iterator[tuple[Key, Draft]]:
        actions, asked = self._actions, TextForm("dock_gateway/srv/Goal_Request", GOAL_ID)
        answered = TextForm("dock_gateway/srv/Goal_Response", ("goal_id", "status"))
        if self._rights.grant.role.includes(Role.AGENT):
            yield (
                (f"{name}/send_goal", f"{kind}_SendGoal"),
                Draft(lambda: (MessageForm(load_action(kind).Goal), answered), lambda goal: actions.send(name, goal)),
            )
            yield (
                (f"{name}/cancel_goal", f"{kind}_CancelGoal"),
                Draft(lambda: (asked, answered), lambda request: actions.cancel(name, request), urgent=True),
            )

        def result() -> Forms:
            fields = ("goal_id", "status", "error")
            return asked, ResultForm("dock_gateway/srv/Result_Response", load_action(kind).Result, fields)

        yield (
            (f"{name}/get_result", f"{kind}_GetResult"),
            Draft(result, lambda request: actions.result(name, request), reads=True),
        )

    def _find(self, seen: GraphScan, actions: Iterable[Key]) -> dict[Key, Draft]:
        """Return the services that the user may call; takes long, so it runs in a thread."""
        of_nodes = self._callable(seen) if self._rights.grant.role.includes(Role.OPERATOR) else ()
        return dict(islice(of_nodes, MAX_SERVICES)) | dict(self._of_gateway(actions))

    def _callable(self, seen: GraphScan) -> Iterator[tuple[Key, Draft]]:
        calls, grant = self._parts[ServiceCalls], self._rights.grant
        for name, service in sorted(seen.services.items()):
            internal = ACTION_PART in name or is_noise(name, service.types)
            if internal or not service.servers or not service.types or not grant.covers_service(name):
                continue
            try:
                calls.require_allowed(FoundService(name, service.types[0], tuple(service.types)))
            except NotAllowed:
                continue
            yield (name, service.types[0]), self._of_node(name, service.types[0])

    def _of_node(self, name: str, kind: str) -> Draft:
        async def call(request: Any) -> Any:
            order = operations.CallService(name, request, kind, TIMEOUT)
            answer = await self._rights.perform(
                operations.call_service,
                {"service": name},
                lambda: operations.call_service(self._parts, self._rights.principal, order),
            )
            return answer.response

        return Draft(lambda: _message_forms(load_service(kind)), call)


def _message_forms(service: Any) -> Forms:
    return MessageForm(service.Request), MessageForm(service.Response)


def _find_forms(drafts: Mapping[Key, Draft]) -> dict[Key, Forms]:
    """Return the forms of services, of those whose types are installed; takes long, so it runs in a thread."""
    found = {}
    for key, draft in drafts.items():
        with suppress(ImportError, TypeError):
            found[key] = draft.forms()
    return found

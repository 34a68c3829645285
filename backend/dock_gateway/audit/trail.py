"""Records requests and the commands of `/ws`."""

import asyncio
import logging
import uuid
from collections.abc import Awaitable, Callable, Mapping
from http import HTTPStatus
from typing import Any, Final, TypeVar

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.audit.record import RequestRecord
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.access import Principal
from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.core.request import PERMIT, Permit
from dock_gateway.http.operation import READS, Audit, Operation, Scope, find_operation
from dock_gateway.http.parts import parts_of
from dock_gateway.http.principal import address_of

log = logging.getLogger(__name__)

STOP = "stop"
OF_GOALS = frozenset({Scope.NEW_GOAL, Scope.GOAL})
T = TypeVar("T")


class Trail:
    """The facts about a request or a command, which is recorded once.

    Args:
        scope: The scope of the request, or of the WebSocket.
        what: The command; None for a request.
        command: Its fields.
        operation: Its requirements.

    Attributes:
        at: When the request arrived, or when it acted if it was authorized: the time of the entry.
        fields: Fields of the entry: `robot`, `action_name`, `goal_id`, `subject`.
    """

    def __init__(
        self,
        scope: ConnectionScope,
        what: str | None = None,
        command: Mapping[str, Any] | None = None,
        operation: Operation | None = None,
    ) -> None:
        self.fields: dict[str, str | None] = {}
        self._command = command
        self._operation = operation
        self._scope: Final = scope
        self._what = what
        self.at = utc_now()
        self._recorded = False
        self._earlier: Final = PERMIT.get()

    def leave_to_commands(self) -> None:
        """Do not record the request, which only carries commands: each of those is recorded."""
        self._recorded = True

    async def record(self, status: int, code: str | None = None) -> None:
        """Record the result, unless it is recorded already. Some entries are stored on return."""
        what = self._what or _name(self._scope, status)
        if what is None or self._recorded:
            return
        self._recorded = True
        try:
            await self._record(what, status, code)
        except Exception:  # whatever goes wrong here, the answer is not to blame
            log.exception("%s could not be recorded", what)

    async def _record(self, what: str, status: int, code: str | None) -> None:
        parts = parts_of(HTTPConnection(self._scope))
        subjects, requests = parts[Subjects], parts[RequestRecord]
        if self._command is None:
            said = subjects.of_request(self._scope)
        else:
            said = subjects.of_names(self._command, Scope.ANY if self._operation is None else self._operation.scope)
        permit = self._permit()
        picked = {} if permit is None or permit.action is None else {"action_name": permit.action}
        fields = subjects.completed({**said, **picked, **self.fields})
        if what == STOP and status < 400:
            fields["robot"] = subjects.stopped(fields["robot"])
        entry = self._entry(what, status, code, fields)
        operation = self._operation or find_operation(self._scope["route"])
        if status < 400 and operation is not None and operation.audit is Audit.STORED_FIRST:
            await requests.store(entry)
        else:
            requests.record(entry)

    def _permit(self) -> Permit | None:
        """Return the authorization, if there is one: an earlier command on the connection may have left its own."""
        permit = PERMIT.get()
        return None if permit is self._earlier else permit

    def _entry(self, what: str, status: int, code: str | None, fields: dict[str, Any]) -> AuditEntry:
        principal: Principal | None = self._scope.get("principal")
        permit = self._permit()
        return AuditEntry(
            id=uuid.uuid4().hex,
            acted_at=self.at if permit is None else permit.acted_at,
            principal=None if principal is None else principal.name,
            role=None if principal is None else principal.grant.role,
            token_id=None if principal is None else principal.credential,
            client=address_of(HTTPConnection(self._scope)) or None,
            request_id=self._scope.get("request_id"),
            what=what,
            status=int(status),
            code=code,
            **fields,
        )


class AuditTrail:
    """ASGI middleware that records each request that changes something, and each operation with `Audit.ALWAYS`."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        trail = scope["audit"] = Trail(scope)

        async def timed_receive() -> Message:
            message = await receive()
            if message["type"] == "http.request" and not message.get("more_body"):
                trail.at = utc_now()
            return message

        async def recorded_send(message: Message) -> None:
            if message["type"] == "http.response.start":
                await trail.record(message["status"], scope.get("problem"))
            await send(message)

        try:
            await self._app(scope, timed_receive, recorded_send)
        except (Exception, asyncio.CancelledError) as error:
            await trail.record(*_failure(error))
            raise


def audited(connection: HTTPConnection, **fields: str | None) -> Trail:
    """Add what only the route knows to the entry of a request: `robot`, `action_name`, `goal_id` or `subject`."""
    trail: Trail = connection.scope["audit"]
    trail.fields.update(fields)
    return trail


async def audited_command(
    scope: ConnectionScope,
    op: str,
    operation: Operation | None,
    fields: Mapping[str, Any],
    carry_out: Callable[[], Awaitable[T]],
    *,
    subject: str | None = None,
) -> T:
    """Carry out a command, and record it if there is such a command. Return its answer, or raise its error.

    Args:
        scope: The scope of the WebSocket, or of the request that it came with.
        op: The command.
        operation: Its requirements; None if there is no such command.
        fields: Its fields.
        carry_out: Carries it out.
        subject: What the record says besides, such as the program that sent it.
    """
    if operation is None or operation.audit is Audit.NEVER:
        return await carry_out()
    trail = Trail(scope, op, dict(fields), operation)
    if subject is not None:
        trail.fields["subject"] = subject
    try:
        answer = await carry_out()
    except GatewayError as error:
        await trail.record(error.status, error.code)
        raise
    except (Exception, asyncio.CancelledError) as error:
        await trail.record(*_failure(error))
        raise
    if operation.scope in OF_GOALS and isinstance(answer, dict) and "goal" in answer:
        trail.fields.update((name, answer["goal"][name]) for name in ("goal_id", "action_name"))
    await trail.record(HTTPStatus.OK)
    return answer


def _failure(error: BaseException) -> tuple[HTTPStatus, str]:
    """Return the status and the code of a request without an answer: the gateway has ended before, or has a bug."""
    if isinstance(error, asyncio.CancelledError):
        return HTTPStatus.SERVICE_UNAVAILABLE, "shutting_down"
    return HTTPStatus.INTERNAL_SERVER_ERROR, "internal_error"


def _name(scope: ConnectionScope, status: int) -> str | None:
    """Return the name of the route, if the request is to be recorded."""
    route, method = scope.get("route"), scope["method"]
    operation = find_operation(route)
    recorded = method not in READS if operation is None else operation.audits(method)
    if method == "OPTIONS" or status == HTTPStatus.METHOD_NOT_ALLOWED or not recorded:
        return None
    name: str | None = getattr(route, "name", None)
    return name

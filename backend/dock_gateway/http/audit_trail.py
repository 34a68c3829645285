"""Records requests and the commands of `/ws` in the audit log."""

import asyncio
import logging
import uuid
from collections.abc import Awaitable, Callable, Iterable, Mapping
from http import HTTPStatus
from typing import Any, Final

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dock_gateway.core.access import Principal
from dock_gateway.core.audit import MAX_ROBOTS, AuditEntry
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.core.filters import parent_of
from dock_gateway.core.namespace import normalize_namespace
from dock_gateway.core.request import PERMIT
from dock_gateway.gateway import Gateway
from dock_gateway.http.operation import READS, Audit, Operation, find_operation
from dock_gateway.http.principal import address_of
from dock_gateway.http.requests import GOAL_ID, get_gateway, read_goal_id

log = logging.getLogger(__name__)

# Parameters of paths that have a column of their own: `name` is that of an action.
COLUMNS = frozenset({"goal_id", "name"})
# What only the request says.
FIELDS = ("robot", "action_name", "goal_id", "subject")


class Trail:
    """What is known of a request or a command before it is recorded, once.

    Args:
        scope: The scope of the request, or of the WebSocket.
        what: The command; None for a request.
        command: Its fields.
        operation: What it needs.

    Attributes:
        at: When the request had arrived. The entry has that, or when the request acted, if it was authorized.
        fields: Of the entry: `robot`, `action_name`, `goal_id`, `subject`.
    """

    def __init__(
        self,
        scope: Scope,
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

    async def record(self, status: int, code: str | None = None) -> None:
        """Record what came of it, unless that is recorded already. Some entries are stored on return."""
        what = self._what or _name(self._scope, status)
        if what is None or self._recorded:
            return
        self._recorded = True
        try:
            await self._record(what, status, code)
        except Exception:  # whatever goes wrong here, the answer is not to blame
            log.exception("%s could not be recorded", what)

    async def _record(self, what: str, status: int, code: str | None) -> None:
        gateway = get_gateway(HTTPConnection(self._scope))
        said = _parameters(self._scope, gateway) if self._command is None else _fields_of(self._command, gateway)
        entry = self._entry(what, status, code, _completed({**said, **self.fields}, gateway))
        operation = self._operation or find_operation(self._scope["route"])
        if status < 400 and operation is not None and operation.audit is Audit.STORED_FIRST:
            await gateway.audit.store(entry)
        else:
            gateway.audit.record(entry)

    def _entry(self, what: str, status: int, code: str | None, fields: dict[str, Any]) -> AuditEntry:
        principal: Principal | None = self._scope.get("principal")
        permit = PERMIT.get()
        return AuditEntry(
            entry_id=uuid.uuid4().hex,
            at=self.at if permit is None else permit.acted_at,
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
    """ASGI middleware that records each request that changes something, and what is `Audit.ALWAYS`."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
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
    scope: Scope,
    op: str,
    operation: Operation | None,
    fields: Mapping[str, Any],
    carry_out: Callable[[], Awaitable[dict[str, Any]]],
) -> dict[str, Any]:
    """Carry out a command of `/ws`, and record it if there is such a command. Return its answer, or raise its error."""
    if operation is None or operation.audit is Audit.NEVER:
        return await carry_out()
    trail = Trail(scope, op, dict(fields), operation)
    try:
        answer = await carry_out()
    except GatewayError as error:
        await trail.record(error.status, error.code)
        raise
    except (Exception, asyncio.CancelledError) as error:
        await trail.record(*_failure(error))
        raise
    if "goal" in answer:
        trail.fields.update((name, answer["goal"][name]) for name in ("goal_id", "action_name"))
    await trail.record(HTTPStatus.OK)
    return answer


def robots_text(robots: Iterable[str]) -> str | None:
    """Return robots as an entry names them, each once. A name that is not valid must not look like several."""
    names = (normalize_namespace(robot).replace(",", "?") for robot in robots)
    return ",".join(dict.fromkeys(names)) or None


def _failure(error: BaseException) -> tuple[HTTPStatus, str]:
    """Return the status and the code of what was not answered: the gateway has ended meanwhile, or has a bug."""
    if isinstance(error, asyncio.CancelledError):
        return HTTPStatus.SERVICE_UNAVAILABLE, "shutting_down"
    return HTTPStatus.INTERNAL_SERVER_ERROR, "internal_error"


def _name(scope: Scope, status: int) -> str | None:
    """Return the name of the route, if the request is to be recorded."""
    route, method = scope.get("route"), scope["method"]
    operation = find_operation(route)
    recorded = method not in READS if operation is None else operation.audits(method)
    if method == "OPTIONS" or status == HTTPStatus.METHOD_NOT_ALLOWED or not recorded:
        return None
    name: str | None = getattr(route, "name", None)
    return name


def _parameters(scope: Scope, gateway: Gateway) -> dict[str, str | None]:
    """Return what the path and the query say."""
    connection = HTTPConnection(scope)
    path, query = connection.path_params, connection.query_params
    if scope["method"] in READS:
        return {"goal_id": path.get("goal_id"), "subject": str(query) or None}
    others = [str(value) for name, value in path.items() if name not in COLUMNS]
    robots: list[str] = []
    if any(field.name == "robot" for field in scope["route"].dependant.query_params):
        robots = query.getlist("robot") or [gateway.settings.namespace]
    return {
        "robot": robots_text(robots),
        "action_name": f"/{path['name']}" if "name" in path else None,
        "goal_id": path.get("goal_id"),
        "subject": ", ".join(others) or None,
    }


def _fields_of(command: Mapping[str, Any], gateway: Gateway) -> dict[str, str | None]:
    """Return what the fields of a command say."""
    names = ("robot", "action", "goal_id")
    robot, action, goal_id = (each if isinstance(each := command.get(name), str) else None for name in names)
    if action is not None:
        action = gateway.settings.resolve(action, robot)
    elif goal_id is None:
        robot = gateway.settings.namespace if robot is None else robot
    return {"robot": robots_text([] if robot is None else [robot]), "action_name": action, "goal_id": goal_id}


def _completed(known: Mapping[str, str | None], gateway: Gateway) -> dict[str, str | None]:
    """Return all fields, with what follows from them: the action of a running goal, the robot of an action."""
    robot, action_name, goal_id, subject = (known.get(name) for name in FIELDS)
    if goal_id is not None and GOAL_ID.fullmatch(goal_id):
        goal_id = read_goal_id(goal_id)
        if action_name is None and (goal := gateway.actions.goal(goal_id)) is not None:
            action_name = goal.action_name
    if action_name is not None:  # a command may name another robot beside an absolute name
        robot = parent_of(gateway.actions.docking.catalog.place_of(action_name))
    if robot is not None and len(robot) > MAX_ROBOTS:
        # There is room for every robot, but not for any number of names that are none.
        present = {each.namespace for each in gateway.robots.all()}
        robot = ",".join(sorted(robot.split(","), key=lambda name: name not in present))
    return dict(zip(FIELDS, (robot, action_name, goal_id, subject), strict=True))

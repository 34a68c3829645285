"""`/users`: those who log in with a name and a password."""

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Request
from starlette.responses import Response

from dock_gateway.access.logins import Logins
from dock_gateway.access.schema import PasswordBody, User, UserBody, UserList
from dock_gateway.access.users import USER_NAME
from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound
from dock_gateway.core.grant import Role
from dock_gateway.http.bodies import Body
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import ThePrincipal, address_of, browser_of, keep_browser, keep_login
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Access"])


async def _name_in_path(user: Annotated[str, Path(json_schema_extra={"pattern": f"^{USER_NAME.pattern}$"})]) -> str:
    return read_user_name(user)


UserName = Annotated[str, Depends(_name_in_path)]


@router.get("/users", name="list_users")
@operation(Role.ADMIN, Scope.EVERY)
async def list_users(logins: Part[Logins]) -> Answer[UserList]:
    """List all users by name, without their passwords."""
    return json_response({"users": await logins.accounts.documents()})


@router.get("/users/{user}", name="get_user")
@operation(Role.ADMIN, Scope.EVERY, errors=(404,))
async def get_user(name: UserName, logins: Part[Logins]) -> Item[User]:
    """Return a user, without the password."""
    return item_response(await logins.accounts.document(name))


@router.put("/users/{user}", name="put_user")
@operation(Role.ADMIN, Scope.EVERY, Audit.STORED_FIRST, errors=(409, 429))
async def put_user(
    name: UserName, body: Body[UserBody], principal: ThePrincipal, logins: Part[Logins], condition: WriteCondition
) -> Item[User]:
    """Add a user, or change one. A changed role holds at once; streams that were opened with the earlier one end."""
    grant, password, disabled = body.grant(), body.password, body.disabled
    try:
        return item_response(await logins.accounts.edit(name, grant, password, disabled=disabled, condition=condition))
    except NotFound:
        condition.require(None)
        if password is None:
            error = FieldError("password", "the password of the new user", "got none")
            raise InvalidField([error]) from None
    user = await logins.accounts.add(name, grant, password, principal.name, disabled=disabled, condition=condition)
    return item_response(user, f"/users/{name}")


@router.delete("/users/{user}", name="remove_user", status_code=204)
@operation(Role.ADMIN, Scope.EVERY, Audit.STORED_FIRST, errors=(409,))
async def remove_user(name: UserName, logins: Part[Logins], condition: ChangeCondition) -> Response:
    """Remove a user, and end their sessions. Their goals go on, and records keep their name."""
    return await removed(logins.accounts.remove(name, condition))


@router.delete("/users/{user}/sessions", name="end_sessions", status_code=204)
@operation(Role.ADMIN, Scope.EVERY, Audit.STORED_FIRST, errors=(404, 409))
async def end_sessions(name: UserName, logins: Part[Logins]) -> Response:
    """Log a user out everywhere."""
    await logins.accounts.end_sessions(name)
    return Response(status_code=204)


@router.put("/session/password", name="change_password", status_code=204)
@operation(Role.VIEWER, Scope.ANY, Audit.STORED_FIRST, errors=(409, 429))
async def change_password(
    body: Body[PasswordBody], request: Request, logins: Part[Logins], principal: ThePrincipal
) -> Response:
    """Change the own password. All sessions end; the browser that asks gets the cookie of a new one."""
    name = require_user(principal)
    secret = await logins.change_password(name, body.old, body.new, address_of(request))
    response = Response(status_code=204)
    keep_login(response, request, secret)
    keep_browser(response, request, logins.guard.known_cookie(name, browser_of(request)))
    return response


def require_user(principal: Principal) -> str:
    """Return the name of a user.

    Raises:
        Conflict: The request is made with a token, or without a login (`user_required`).
    """
    if principal.kind is not PrincipalKind.USER or principal.name is None:
        raise Conflict("this is for users who logged in with a name and a password", code="user_required")
    return principal.name


def read_user_name(value: str) -> str:
    """Return the name of a user.

    Raises:
        InvalidField: It cannot be one.
    """
    if not USER_NAME.fullmatch(value):
        expected = "up to 60 lower-case letters and digits, with . _ - @ + between them"
        raise InvalidField([FieldError("user", expected, f"got {value[:60]!r}", "path")])
    return value

"""The JSON shapes of users, tokens and of the login."""

from datetime import datetime
from functools import partial
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, model_validator

from dock_gateway.access.passwords import MAX_PASSWORD, MIN_PASSWORD, describe_wrong
from dock_gateway.core import grant as stored
from dock_gateway.core.access import PrincipalKind
from dock_gateway.core.errors import got
from dock_gateway.core.grant import LIMITS, MAX_PATTERN, MAX_PATTERNS, Role
from dock_gateway.http.bodies import Name60, Unique, expected
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Schema
from dock_gateway.setting_types import PATTERN


class Grant(Schema):
    """What someone may do. An empty list means every robot, or every action or topic of the robots."""

    role: Role
    robots: list[str]
    actions: list[str]
    topics: list[str]


def _check_pattern(value: str) -> str:
    if len(value) > MAX_PATTERN or not PATTERN.fullmatch(value):
        raise expected("a name such as /robot1 or /hall_a/*")
    return value


def _check_password(value: object, shortest: int = MIN_PASSWORD) -> object:
    if (wrong := describe_wrong(value, shortest)) is not None:
        raise expected(*wrong)
    return value


Pattern = Annotated[
    str,
    AfterValidator(_check_pattern),
    Field(json_schema_extra={"maxLength": MAX_PATTERN, "pattern": f"^(?:{PATTERN.pattern})$"}),
]
Patterns = Annotated[tuple[Pattern, ...], Field(max_length=MAX_PATTERNS), Unique]
Password = Annotated[
    str,
    BeforeValidator(_check_password),
    Field(
        description="At least 12 characters, whatever they are",
        json_schema_extra={"minLength": MIN_PASSWORD, "maxLength": MAX_PASSWORD},
    ),
]
OldPassword = Annotated[
    str,
    BeforeValidator(partial(_check_password, shortest=1)),
    Field(json_schema_extra={"minLength": 1, "maxLength": MAX_PASSWORD}),
]


class GrantBody(Schema):
    """A role, and its limits: in a name, `*` stands for any text."""

    role: Role
    robots: Annotated[Patterns, Field(description="Namespaces of robots; none means every robot")] = ()
    actions: Annotated[Patterns, Field(description="Names of actions; none means every action of the robots")] = ()
    topics: Annotated[Patterns, Field(description="Names of topics; none means every topic of the robots")] = ()

    @model_validator(mode="after")
    def _do_not_limit_an_admin(self) -> Self:
        limited = next((name for name in LIMITS if getattr(self, name)), None)
        if self.role is Role.ADMIN and limited is not None:
            detail = got(getattr(self, limited))
            raise expected("none, as an admin can change any limit", detail, path=limited)
        return self

    def grant(self) -> stored.Grant:
        """Return the grant."""
        return stored.Grant(self.role, self.robots, self.actions, self.topics)


class TokenBody(GrantBody):
    """A token to be made. `name` is who uses it: a person or a script."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"name": "night shift script", "role": "operator", "robots": ["/hall_a/*"], "days": 90}]
        }
    )

    name: Name60
    days: Annotated[
        int | None, Field(ge=1, le=3650, description="For how long it is valid; null: until it is revoked")
    ] = None


class UserBody(GrantBody):
    """A user to be added or changed. A new one needs a password; a changed password ends the user's sessions."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"role": "operator", "robots": ["/hall_a/*"], "password": "correct horse battery staple"}]
        }
    )

    disabled: Annotated[bool, Field(description="Whether the user cannot log in")] = False
    password: Password | None = None


class PasswordBody(Schema):
    """A change of the own password."""

    old: OldPassword
    new: Password


class Requester(Grant):
    """Who makes a request. `name` is null where requests need no login."""

    name: str | None
    kind: PrincipalKind


class Provider(Schema):
    """An identity provider, at which people log in with `/session/oidc`. `logout_url` is its page for logging out."""

    name: str
    logout_url: str | None


class Session(Schema):
    """Whether requests need a login, and who makes this one; null if its login is missing or not valid.

    `open_to` is who may do everything without a login: the programs of the gateway's machine, or everyone on the
    network; null where requests need one. `hub` is whether this is a hub of many sites, rather than a gateway.
    `share` are patterns of the robots that this gateway serves; none if that is every robot, or nobody is logged in.
    """

    required: bool
    open_to: Literal["machine", "network"] | None
    principal: Requester | None
    provider: Provider | None
    hub: bool
    share: list[str]


class Token(Grant, Versioned):
    """A token without its secret. `used_at` is to the minute."""

    id: str
    name: str
    created_by: str | None
    created_at: datetime
    expires_at: datetime | None
    used_at: datetime | None
    valid: bool


class Ticket(Schema):
    """A ticket for one WebSocket."""

    ticket: str
    expires_in_s: float


class CreatedToken(Token):
    """A new token with its secret, which is not shown again."""

    secret: str


class TokenList(Schema):
    """The tokens, by name."""

    tokens: list[Token]


class User(Grant, Versioned):
    """A user without the password. `sessions` is the number of logins that have not ended."""

    name: str
    disabled: bool
    created_by: str | None
    created_at: datetime
    logged_in_at: datetime | None
    sessions: int


class UserList(Schema):
    """The users, by name."""

    users: list[User]

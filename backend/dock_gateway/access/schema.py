"""The JSON shapes of users, tokens and of the login."""

from datetime import datetime
from typing import Literal

from dock_gateway.core.access import Kind
from dock_gateway.core.grant import Role
from dock_gateway.http.schema import Schema


class Grant(Schema):
    """What someone may do. An empty list means every robot, or every action or topic of the robots."""

    role: Role
    robots: list[str]
    actions: list[str]
    topics: list[str]


class Requester(Grant):
    """Who makes a request. `name` is null where requests need no login."""

    name: str | None
    kind: Kind


class Provider(Schema):
    """An identity provider, at which people log in with `/session/oidc`. `logout_url` is its page for logging out."""

    name: str
    logout_url: str | None


class Session(Schema):
    """Whether requests need a login, and who makes this one; null if its login is missing or not valid.

    `open_to` is who may do everything without a login: the programs of the gateway's machine, or everyone on the
    network; null where requests need one.
    """

    required: bool
    open_to: Literal["machine", "network"] | None
    principal: Requester | None
    provider: Provider | None


class Token(Grant):
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


class User(Grant):
    """A user without the password. `sessions` is the number of logins that have not ended."""

    name: str
    disabled: bool
    created_by: str | None
    created_at: datetime
    logged_in_at: datetime | None
    sessions: int


class Person(Grant):
    """A person who is logged in with the identity provider. `subject` is the provider's id of them."""

    name: str
    subject: str
    sessions: int
    logged_in_at: datetime
    expires_at: datetime


class PersonList(Schema):
    """The people, by name."""

    people: list[Person]


class UserList(Schema):
    """The users, by name."""

    users: list[User]

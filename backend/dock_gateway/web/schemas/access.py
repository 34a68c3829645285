"""The JSON shapes of tokens and of the login."""

from datetime import datetime

from dock_gateway.core.access import Role
from dock_gateway.web.schemas.common import Schema


class Requester(Schema):
    """Who makes a request. `name` is null where requests need no token."""

    name: str | None
    role: Role


class Session(Schema):
    """Whether requests need a token, and who makes this one; null if its token is missing or not valid."""

    required: bool
    principal: Requester | None


class Token(Schema):
    """A token without its secret. `used_at` is to the minute."""

    id: str
    name: str
    role: Role
    created_by: str | None
    created_at: datetime
    expires_at: datetime | None
    used_at: datetime | None
    valid: bool


class CreatedToken(Token):
    """A new token with its secret, which is not shown again."""

    secret: str


class TokenList(Schema):
    """The tokens, by name."""

    tokens: list[Token]

"""Tokens, which gateways share through the history, and who shows them."""

import logging
import time
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from dock_gateway.access.credentials import ID_DIGITS, Credentials, new_secret
from dock_gateway.core.access import Principal, PrincipalKind, Token
from dock_gateway.core.errors import Conflict, NotAuthenticated
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.storage import Dependency
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

MAX_TOKENS = 500
PREFIX = "dgw_"
# Seconds between two log lines that a token is not known here.
SAID_EVERY = 600.0


class Tokens(Credentials[Token]):
    """The tokens.

    Revocations and changes at other gateways are known after `SYNC_INTERVAL` seconds. While the history does not
    answer, the tokens that were valid before go on.

    Args:
        book: Stores them.
        where: The database, for the log.
    """

    refusal = "the token is not known, was revoked or has expired"

    def __init__(self, book: SharedBook[Token], where: str = "") -> None:
        super().__init__(book)
        self._where = where
        self._said_at: float | None = None

    def identify(self, secret: str) -> Principal:
        """Return who shows the secret of a token.

        Raises:
            NotAuthenticated: There is no valid token with it (`invalid_token`). If it is not known at all, the log says
                where this gateway's are: it may have been created in another database.
        """
        try:
            return super().identify(secret)
        except NotAuthenticated:
            if secret.startswith(PREFIX) and self.find(secret) is None:
                self._say_unknown(time.monotonic())
            raise

    def _say_unknown(self, now: float) -> None:
        if self._where and (self._said_at is None or now - self._said_at >= SAID_EVERY):
            self._said_at = now
            log.warning(
                "a token was shown that is not in %s. It was removed, or created in another database: `dock-gateway "
                "token create` says where it stores one, and --database-url names the database (docs/access.md)",
                self._where,
            )

    def _valid(self, entry: Token) -> bool:
        return entry.valid(utc_now())

    def _principal(self, key: str, entry: Token) -> Principal:
        return Principal(entry.name, PrincipalKind.TOKEN, entry.grant, key)

    def name_of(self, token_id: str) -> str | None:
        """Return the name of a token, if there is one with this id."""
        token = self.book.get(token_id)
        return None if token is None else token.name

    async def create(
        self,
        name: str,
        grant: Grant,
        expires_at: datetime | None = None,
        by: str | None = None,
        dependency: Dependency | None = None,
    ) -> tuple[dict[str, Any], str]:
        """Create a token; return it as the API shows it, and its secret, which is not stored.

        Args:
            name: Its name.
            grant: What it may do.
            expires_at: When it becomes invalid.
            by: Who creates it.
            dependency: Entries of another kind that are checked in the same transaction.

        Raises:
            Conflict: There are too many (`limit_reached`), or one has this name (`token_exists`).
            Unavailable: The history does not answer (`history_unavailable`); there is no new token.
        """
        secret, digest = new_secret(PREFIX)
        token = Token(
            name,
            **grant.fields(),
            digest=digest,
            created_by=by,
            created_at=utc_now(),
            expires_at=expires_at,
            used_at=None,
        )

        def check(tokens: Mapping[str, Token]) -> None:
            if any(each.name == name for each in tokens.values()):
                raise Conflict(f"there is a token of the name {name}; revoke it first", code="token_exists")

        await self.book.replace(digest[:ID_DIGITS], token, check, dependency)
        return self._document(digest[:ID_DIGITS], token), secret

    async def documents(self) -> list[dict[str, Any]]:
        """Return all tokens by name, as the API shows them.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        tokens = await self.book.read()
        found = [self._document(token_id, token) for token_id, token in tokens.items()]
        return sorted(found, key=lambda token: str(token["name"]))

    async def document(self, token_id: str) -> dict[str, Any]:
        """Return a token as the API shows it.

        Raises:
            NotFound: There is no such token (`token_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return self._document(token_id, await self.book.find(token_id))

    def _document(self, token_id: str, token: Token) -> dict[str, Any]:
        return token_document(token_id, token) | {"etag": self.book.etag(token)}

    def without(self, name: str) -> Dependency:
        """Return a check that no token has the name of a user, whatever its case."""

        def check(tokens: Mapping[str, Token]) -> None:
            if any(token.name.lower() == name for token in tokens.values()):
                raise Conflict(f"there is a token of the name {name}", code="token_exists")

        return self.book.dependency(check)

    def have_admin(self) -> bool:
        """Return whether there is a valid token of an admin."""
        now = utc_now()
        return any(token.role is Role.ADMIN and token.valid(now) for token in self.book.all().values())


def token_document(token_id: str, token: Token) -> dict[str, Any]:
    """Return a token as the API shows it."""
    document = {"id": token_id, **vars(token), "valid": token.valid(utc_now())}
    del document["digest"]
    return document

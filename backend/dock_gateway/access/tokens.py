"""Tokens, which gateways share through the history, and who shows them."""

import asyncio
import hashlib
import hmac
import logging
import secrets
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace
from datetime import datetime, timedelta
from typing import Any

from dock_gateway.core.access import Kind, Principal, Token
from dock_gateway.core.errors import Conflict, GatewayError, NotAuthenticated
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.core.tasks import Tasks
from dock_gateway.fleet.shared_book import SharedBook
from dock_gateway.fleet.shared_entries import SYNC_INTERVAL

log = logging.getLogger(__name__)

MAX_TOKENS = 500
PREFIX = "dgw_"
SECRET_BYTES = 32
# Digits of a secret's digest that are the id of its token.
ID_DIGITS = 16
# Time between two records of the use of a token.
USED_EVERY = timedelta(minutes=1)


class Tokens:
    """The tokens.

    Revocations and changes at other gateways are known after `SYNC_INTERVAL` seconds. While the history does not
    answer, the tokens that were valid before go on.

    Args:
        book: Stores them.
    """

    def __init__(self, book: SharedBook[Token]) -> None:
        self._book = book
        self._used: dict[str, datetime] = {}
        self._streams: dict[str, set[Callable[[], None]]] = {}
        self._tasks = Tasks("watching tokens")

    async def open(self) -> None:
        """Read the tokens, and watch them from now on."""
        if await self._book.sync() and not self._book.keys():
            log.warning("there is no token yet: `dock-gateway token create NAME --role admin` creates one")
        self._tasks.spawn(self._run())

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(SYNC_INTERVAL)
            await self.look()

    def identify(self, secret: str | None) -> Principal:
        """Return who shows this secret.

        Raises:
            NotAuthenticated: There is no secret, or no valid token with it (`invalid_token`).
        """
        if secret is None:
            raise NotAuthenticated("this gateway asks for a token: log in, or send `Authorization: Bearer dgw_…`")
        digest = digest_of(secret)
        token_id = digest[:ID_DIGITS]
        token = self._valid(token_id)
        if token is None or not hmac.compare_digest(token.digest, digest):
            raise NotAuthenticated("the token is not known, was revoked or has expired", code="invalid_token")
        self._used[token_id] = utc_now()
        return Principal(token.name, Kind.TOKEN, token.grant, token_id)

    def is_valid(self, token_id: str) -> bool:
        """Return whether a token has neither been revoked nor expired."""
        return self._valid(token_id) is not None

    def name_of(self, token_id: str) -> str | None:
        """Return the name of a token, if there is one with this id."""
        token = self._book.get(token_id)
        return None if token is None else token.name

    @contextmanager
    def watch(self, token_id: str, end: Callable[[], None]) -> Iterator[None]:
        """Call `end` as soon as it is known that a token is no longer valid, while the block runs."""
        ends = self._streams.setdefault(token_id, set())
        ends.add(end)
        try:
            yield
        finally:
            ends.discard(end)

    def _valid(self, token_id: str) -> Token | None:
        token = self._book.get(token_id)
        return token if token is not None and token.valid(utc_now()) else None

    async def create(
        self, name: str, grant: Grant, expires_at: datetime | None = None, by: str | None = None
    ) -> tuple[dict[str, Any], str]:
        """Create a token; return it as the API shows it, and its secret, which is not stored.

        Raises:
            Conflict: There are too many (`too_many_tokens`), or one has this name (`token_exists`).
            Unavailable: The history does not answer (`history_unavailable`); there is no new token.
        """
        secret = PREFIX + secrets.token_urlsafe(SECRET_BYTES)
        digest = digest_of(secret)
        token = Token(
            name,
            **asdict(grant),
            digest=digest,
            created_by=by,
            created_at=utc_now(),
            expires_at=expires_at,
            used_at=None,
        )

        def check(tokens: Mapping[str, Token]) -> None:
            if any(each.name == name for each in tokens.values()):
                raise Conflict(f"there is a token of the name {name}; revoke it first", code="token_exists")

        await self._book.replace(digest[:ID_DIGITS], token, check)
        return token_document(digest[:ID_DIGITS], token), secret

    async def revoke(self, token_id: str) -> None:
        """Make a token invalid, and end its streams.

        Raises:
            NotFound: There is no such token (`token_not_found`).
            Unavailable: The history does not answer (`history_unavailable`); the token is still valid.
        """
        await self._book.remove(token_id)
        self._end_streams()

    async def documents(self) -> list[dict[str, Any]]:
        """Return all tokens by name, as the API shows them.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        tokens = await self._book.read()
        found = [token_document(token_id, token) for token_id, token in tokens.items()]
        return sorted(found, key=lambda token: str(token["name"]))

    async def look(self) -> None:
        """End the streams of invalid tokens, record which were used, and read changes of other gateways."""
        self._end_streams()
        used, self._used = self._used, {}
        for token_id, at in used.items():
            await self._record_use(token_id, at)
        await self._book.sync()
        self._end_streams()

    async def _record_use(self, token_id: str, at: datetime) -> None:
        token = self._book.get(token_id)
        if token is not None and (token.used_at is None or at - token.used_at >= USED_EVERY):
            with suppress(GatewayError):  # revoked elsewhere, or not stored: it is not that important
                await self._book.amend(token_id, replace(token, used_at=at))

    def _end_streams(self) -> None:
        for token_id, ends in list(self._streams.items()):
            if not self.is_valid(token_id):
                for end in list(ends):
                    end()
            if not ends:
                del self._streams[token_id]

    async def close(self) -> None:
        """Watch no longer."""
        await self._tasks.close()


def digest_of(secret: str) -> str:
    """Return the digest that is stored instead of a secret. A plain hash is enough for 256 random bits."""
    return hashlib.sha256(secret.encode(errors="surrogatepass")).hexdigest()


def token_document(token_id: str, token: Token) -> dict[str, Any]:
    """Return a token as the API shows it."""
    document = {"id": token_id, **vars(token), "valid": token.valid(utc_now())}
    del document["digest"]
    return document

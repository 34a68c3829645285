"""Secrets that show who makes a request. Gateways share them through the history, without the secrets themselves."""

import hashlib
import hmac
import secrets
from contextlib import suppress
from dataclasses import replace
from datetime import datetime, timedelta
from typing import Generic, TypeVar

from dock_gateway.core.access import Session, Token
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.fleet.shared_book import SharedBook

SECRET_BYTES = 32
# Digits of a secret's digest that are the id of its entry.
ID_DIGITS = 16
# Time between two records of the use of a secret.
USED_EVERY = timedelta(minutes=1)

CredentialT = TypeVar("CredentialT", Token, Session)


class Credentials(Generic[CredentialT]):
    """Tokens or sessions by id, found by their secrets.

    Args:
        book: Stores them.
    """

    def __init__(self, book: SharedBook[CredentialT]) -> None:
        self.book: SharedBook[CredentialT] = book
        self._used: dict[str, datetime] = {}

    def find(self, secret: str) -> tuple[str, CredentialT] | None:
        """Return the id and the entry of a secret, which need not be valid; None if there is none."""
        digest = digest_of(secret)
        key = digest[:ID_DIGITS]
        entry = self.book.get(key)
        return None if entry is None or not hmac.compare_digest(entry.digest, digest) else (key, entry)

    def use(self, key: str) -> None:
        """Note that an entry is used now; `look` records it."""
        self._used[key] = utc_now()

    async def look(self) -> None:
        """Record which were used, and read changes of other gateways."""
        used, self._used = self._used, {}
        for key, at in used.items():
            await self._record_use(key, at)
        await self.book.sync()

    async def _record_use(self, key: str, at: datetime) -> None:
        entry = self.book.get(key)
        if entry is not None and (entry.used_at is None or at - entry.used_at >= USED_EVERY):
            with suppress(GatewayError):  # it has ended elsewhere, or cannot be stored: it is not that important
                await self.book.amend(key, replace(entry, used_at=at))


def new_secret(prefix: str) -> tuple[str, str]:
    """Return a new secret and its digest."""
    secret = prefix + secrets.token_urlsafe(SECRET_BYTES)
    return secret, digest_of(secret)


def digest_of(secret: str) -> str:
    """Return the digest that is stored instead of a secret. A plain hash is enough for 256 random bits."""
    return hashlib.sha256(secret.encode(errors="surrogatepass")).hexdigest()

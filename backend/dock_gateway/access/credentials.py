"""Secrets that show who makes a request. Gateways share them through the history, without the secrets themselves."""

import hashlib
import hmac
import secrets
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import replace
from datetime import datetime, timedelta
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, NotAuthenticated
from dock_gateway.core.event import utc_now
from dock_gateway.storage.shared_entries import SharedBook

SECRET_BYTES = 32
# Digits of a secret's digest that are the id of its entry.
ID_DIGITS = 16
# Time between two records of the use of a secret.
USED_EVERY = timedelta(minutes=1)


class Credential(Protocol):
    """A token or a session as it is stored: a dataclass, without its secret."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def digest(self) -> str:
        """SHA-256 of the secret, in hexadecimal digits."""

    @property
    def used_at(self) -> datetime | None:
        """When it was used last, to the minute; None: never."""


CredentialT = TypeVar("CredentialT", bound=Credential)


class Credentials(ABC, Generic[CredentialT]):
    """Tokens or sessions by id, found by their secrets.

    Args:
        book: Stores them.
    """

    refusal: ClassVar[str]  # why a secret is refused

    def __init__(self, book: SharedBook[CredentialT]) -> None:
        self.book: SharedBook[CredentialT] = book
        self._used: dict[str, datetime] = {}

    def find(self, secret: str) -> tuple[str, CredentialT] | None:
        """Return the id and the entry of a secret, which need not be valid; None if there is none."""
        digest = digest_of(secret)
        key = digest[:ID_DIGITS]
        entry = self.book.get(key)
        return None if entry is None or not hmac.compare_digest(entry.digest, digest) else (key, entry)

    def principal(self, key: str) -> Principal | None:
        """Return who shows an entry, with what they may do now, if it is valid."""
        entry = self.book.get(key)
        return None if entry is None or not self._valid(entry) else self._principal(key, entry)

    @abstractmethod
    def _valid(self, entry: CredentialT) -> bool:
        """Return whether an entry has not ended."""

    @abstractmethod
    def _principal(self, key: str, entry: CredentialT) -> Principal:
        """Return who shows a valid entry."""

    def identify(self, secret: str) -> Principal:
        """Return who shows this secret.

        Raises:
            NotAuthenticated: There is no valid entry with it (`invalid_token`).
        """
        found = self.find(secret)
        principal = None if found is None else self.principal(found[0])
        if found is None or principal is None:
            raise NotAuthenticated(self.refusal, code="invalid_token")
        self._used[found[0]] = utc_now()  # `refresh` records it
        return principal

    async def refresh(self) -> None:
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

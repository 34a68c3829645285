"""Passwords: their hashes. Hashing takes 64 MB and a tenth of a second each time, in a thread."""

import asyncio
import secrets
import unicodedata
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from cryptography.exceptions import InvalidKey
from cryptography.hazmat.primitives.kdf.argon2 import Argon2id

from dock_gateway.core.request import slot

T = TypeVar("T")

MIN_PASSWORD, MAX_PASSWORD = 12, 200  # characters
# One password is hashed at a time: the lanes are threads of OpenSSL, which a process has once, and two hashes wait for
# each other without end. How many may wait, `http.quotas` says.
_hashing = ThreadPoolExecutor(1, "passwords")


@dataclass(frozen=True)
class Cost:
    """What a hash costs who makes it, and who tries passwords.

    Attributes:
        memory: KiB.
        passes: How often the memory is gone through.
        lanes: How many threads could do so at the same time.
    """

    memory: int
    passes: int
    lanes: int

    def __str__(self) -> str:
        """Return how a hash with this cost begins."""
        return f"$argon2id$v=19$m={self.memory},t={self.passes},p={self.lanes}$"


# The second recommendation of RFC 9106, for where memory is limited.
COST = Cost(memory=64 * 1024, passes=3, lanes=4)


def describe_wrong(value: object, shortest: int = MIN_PASSWORD) -> tuple[str, str] | None:
    """Return what is expected and what was received instead of a password, without repeating it; None if it is right.

    Wrong is what is too short, too long or not a text.
    """
    if isinstance(value, str) and shortest <= len(value) <= MAX_PASSWORD:
        return None
    detail = f"got {len(value)} characters" if isinstance(value, str) else "got something else"
    return f"{shortest} to {MAX_PASSWORD} characters", detail


class Passwords:
    """Hashes passwords with Argon2id, one at a time."""

    def __init__(self) -> None:
        self._nobodys: str | None = None

    async def hash(self, password: str) -> str:
        """Return the hash to store.

        Raises:
            TooManyRequests: Too many of the user wait, or of all users together (`too_many_logins`).
        """
        return await self._run(partial(_hash, normalize(password)))

    async def verify(self, password: str, hashed: str | None) -> tuple[bool, str | None]:
        """Return whether a password is right, and a new hash if the stored one is outdated.

        Args:
            password: The password.
            hashed: The stored hash; None if there is no such user, which takes as long.

        Raises:
            TooManyRequests: Too many of the user wait, or of all users together (`too_many_logins`).
        """
        if self._nobodys is None:
            self._nobodys = await self.hash(secrets.token_hex())
        check = partial(_verify, normalize(password), self._nobodys if hashed is None else hashed)
        right, outdated = await self._run(check)
        return right and hashed is not None, outdated

    async def _run(self, work: Callable[[], T]) -> T:
        with slot("logins"):
            return await asyncio.get_running_loop().run_in_executor(_hashing, work)


def _hash(password: bytes) -> str:
    salt = secrets.token_bytes(16)
    return Argon2id(
        salt=salt, length=32, iterations=COST.passes, lanes=COST.lanes, memory_cost=COST.memory
    ).derive_phc_encoded(password)


def _verify(password: bytes, hashed: str) -> tuple[bool, str | None]:
    try:
        Argon2id.verify_phc_encoded(password, hashed)
    except (InvalidKey, ValueError):  # ValueError: what is stored is no hash
        return False, None
    return True, None if hashed.startswith(str(COST)) else _hash(password)


def normalize(password: str) -> bytes:
    """Return a password as it is hashed: keyboards send the same letter in several ways."""
    return unicodedata.normalize("NFKC", password).encode(errors="surrogatepass")

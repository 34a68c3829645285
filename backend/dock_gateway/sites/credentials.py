"""Who a program is at a NATS server: a `.creds` file, as `nsc` writes it."""

import base64
import re
from dataclasses import dataclass
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

# What a decoded seed of a user begins with: "a seed" (5 bits) and "of a user" (8 bits), filled up with zeros.
USER_SEED = bytes((18 << 3 | 20 << 3 >> 5, (20 << 3 & 31) << 3))


@dataclass(frozen=True, repr=False)
class NatsCredentials:
    """The signed name of a user, and the key that proves it.

    Attributes:
        jwt: Who the user is and what they may do, signed by their account.
    """

    jwt: str
    _key: Ed25519PrivateKey

    def sign(self, nonce: str) -> bytes:
        """Return the signature that a server asks for, in base64."""
        return base64.b64encode(self._key.sign(nonce.encode()))


def read_credentials(path: Path) -> NatsCredentials:
    """Read a `.creds` file.

    Raises:
        ValueError: It cannot be read, or is none.
    """
    try:
        text = path.read_text("ascii")
    except (OSError, ValueError) as error:
        raise ValueError(f"the NATS credentials in {path} cannot be read: {error}") from None
    jwt, seed = (_part(path, text, name) for name in ("NATS USER JWT", "USER NKEY SEED"))
    try:
        decoded = base64.b32decode(seed + "=" * (-len(seed) % 8))
        if decoded[:2] != USER_SEED or len(decoded) != 36:  # 32 bytes of the key, 2 of a checksum
            raise ValueError
    except ValueError:
        raise ValueError(f"{path} is no file of NATS credentials: its seed is none of a user") from None
    return NatsCredentials(jwt, Ed25519PrivateKey.from_private_bytes(decoded[2:34]))


def _part(path: Path, text: str, name: str) -> str:
    found = re.search(rf"BEGIN {name}-*\s+(\S+)", text)
    if found is None:
        raise ValueError(f"{path} is no file of NATS credentials: it has no {f'BEGIN {name}'!r}")
    return found[1]

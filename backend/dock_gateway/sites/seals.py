"""A key that a hub and a process of a site share, so that the site knows the hub's messages at little cost.

A signature takes a hundred times as long to verify as a seal. So a site looks at the seal first: whatever others send,
it costs next to nothing. A seal replaces no signature: each request is signed, too.
"""

import hashlib
import hmac
from typing import Final

from joserfc.errors import JoseError
from joserfc.jwk import OKPKey

CURVE: Final = "X25519"
# Characters of a seal.
SEAL = 64


class KeyAgreement:
    """One end of a key agreement (X25519). The pair of keys is made for this process.

    Attributes:
        public: The public key, for the other end.
    """

    def __init__(self) -> None:
        self._private = OKPKey.generate_key(CURVE)
        self.public = str(self._private.as_dict(private=False)["x"])

    def agree(self, public: str, site: str, instance: str) -> bytes:
        """Return the key that is shared with the other end (HKDF, RFC 5869).

        Args:
            public: Its public key.
            site: The site that uses it.
            instance: The process there.

        Raises:
            ValueError: It is not a public key.
        """
        try:
            secret = self._private.exchange_derive_key(OKPKey.import_key({"kty": "OKP", "crv": CURVE, "x": public}))
        except (JoseError, TypeError) as error:
            raise ValueError(str(error)) from None
        extracted = hmac.digest(bytes(32), secret, hashlib.sha256)
        return hmac.digest(extracted, f"dock-gateway seal {site} {instance}\x01".encode(), hashlib.sha256)


def seal(key: bytes, message: bytes) -> bytes:
    """Return a message with its seal in front."""
    return _mac(key, message) + message


def unseal(key: bytes | None, data: bytes) -> bytes | None:
    """Return the sealed message; None if it has no seal, or a forged one."""
    message = data[SEAL:]
    return message if key is not None and hmac.compare_digest(data[:SEAL], _mac(key, message)) else None


def without_seal(data: bytes) -> bytes:
    """Return a message, a JSON object, without the seal that may be in front of it, valid or not."""
    return data if data.startswith(b"{") else data[SEAL:]


def _mac(key: bytes, message: bytes) -> bytes:
    return hmac.digest(key, message, hashlib.sha256).hex().encode()

"""An operator, an account and its users, as `nsc` makes them: signed JWTs and `.creds` files."""

import base64
import hashlib
import json
import os
import time
from pathlib import Path
from typing import Any

import nkeys


def _key(kind: int) -> nkeys.KeyPair:
    return nkeys.from_seed(nkeys.encode_seed(os.urandom(32), kind))


def _base64(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def _jwt(issuer: nkeys.KeyPair, subject: nkeys.KeyPair, name: str, nats: dict[str, Any]) -> str:
    claims = {
        "iat": int(time.time()), "iss": issuer.public_key.decode(), "name": name, "sub": subject.public_key.decode(),
        "nats": {"version": 2, **nats},
    }  # fmt: skip
    claims["jti"] = base64.b32encode(hashlib.sha256(json.dumps(claims).encode()).digest()).rstrip(b"=").decode()
    head = _base64(json.dumps({"typ": "JWT", "alg": "ed25519-nkey"}).encode())
    text = f"{head}.{_base64(json.dumps(claims).encode())}"
    return f"{text}.{_base64(issuer.sign(text.encode()))}"


class NatsAccount:
    """One account of a new operator."""

    def __init__(self) -> None:
        self._operator, self._account = _key(nkeys.PREFIX_BYTE_OPERATOR), _key(nkeys.PREFIX_BYTE_ACCOUNT)

    @property
    def config(self) -> str:
        """What a server needs, to know the account."""
        operator = _jwt(self._operator, self._operator, "operator", {"type": "operator"})
        limits = dict.fromkeys(("subs", "data", "payload", "imports", "exports", "conn", "leaf"), -1)
        account = _jwt(self._operator, self._account, "sites", {"type": "account", "limits": limits})
        name = self._account.public_key.decode()
        return f'operator: "{operator}"\nresolver: MEMORY\nresolver_preload: {{ {name}: "{account}" }}'

    def add_user(self, file: Path, publish: list[str], subscribe: list[str]) -> Path:
        """Write the `.creds` file of a user that may answer requests, too."""
        user = _key(nkeys.PREFIX_BYTE_USER)
        rights = {"pub": {"allow": publish}, "sub": {"allow": subscribe}, "resp": {"max": 1, "ttl": 60 * 10**9}}
        jwt = _jwt(self._account, user, file.stem, {"type": "user", "subs": -1, "data": -1, "payload": -1, **rights})
        file.write_text(
            f"-----BEGIN NATS USER JWT-----\n{jwt}\n------END NATS USER JWT------\n\n"
            f"-----BEGIN USER NKEY SEED-----\n{user.seed.decode()}\n------END USER NKEY SEED------\n"
        )
        return file

"""Verifies JWTs of the provider: keys, signatures and the claims that every one has. Pure: the time is given."""

import base64
import binascii
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any
from warnings import catch_warnings

import orjson
from joserfc import jwt
from joserfc.errors import JoseError, SecurityWarning, UnsupportedAlgorithmError
from joserfc.jwa import JWSAlgModel
from joserfc.jwk import ECKey, OKPKey, RSAKey, import_key
from joserfc.jws import JWSRegistry

from dock_gateway.core.errors import NotAuthenticated

Key = RSAKey | ECKey | OKPKey

# Seconds by which the provider's clock may be ahead of ours, and behind it.
AHEAD, BEHIND = 10.0, 2.0
MAX_TOKEN = 16_384  # characters
MAX_KEYS = 50
MIN_RSA_BITS = 2048
# The year 9999, in seconds since 1970: what a datetime can hold.
END_OF_TIME = 253_402_300_000
# The kind of an access token, if it says so (RFC 9068). Most providers call each of their JWTs so, or nothing.
ACCESS_TOKEN = "at+jwt"  # noqa: S105 - it is none
ANY_KINDS = ("", "jwt")
# Claims by which providers name the use of a token, and what they call an access token: Keycloak, Cognito and others.
USES, ACCESS = ("typ", "token_type", "token_use"), ("bearer", "access")
# Claims that ID tokens and events have, and access tokens that do not say what they are have not.
OTHER_CLAIMS = ("nonce", "at_hash", "c_hash", "s_hash", "events")
# Claims that access tokens have, and ID tokens have not: of any provider; of Entra ID's for services.
SCOPES = ("scope", "scp", "azpacr", "appidacr")
# Kinds of keys by how the names of their algorithms begin.
KINDS = {"RS": "RSA", "PS": "RSA", "ES": "EC", "Ed": "OKP"}


@dataclass(frozen=True)
class Header:
    """The header of a JWT, which describes its signature; not verified.

    Attributes:
        algorithm: The algorithm.
        key_id: Which key; None if it does not say.
        kind: What kind of JWT it is, in lower case; empty if it does not say.
    """

    algorithm: str
    key_id: str | None
    kind: str


@dataclass(frozen=True)
class Signed:
    """The claims of a JWT whose signature is right.

    Attributes:
        claims: The claims.
        key: Thumbprint of the key.
    """

    claims: Mapping[str, Any]
    key: str


class Registry(JWSRegistry):
    """The algorithms that are accepted: exactly those, and `EdDSA` without a warning that there is a newer name."""

    def get_alg(self, name: str) -> JWSAlgModel:
        """Return an algorithm.

        Raises:
            UnsupportedAlgorithmError: It is not accepted.
        """
        if name not in (self.allowed or ()) or name not in self.algorithms:
            raise UnsupportedAlgorithmError(name)
        return self.algorithms[name]


class Keys:
    """The public keys of the provider.

    Args:
        keys: The keys.
    """

    def __init__(self, keys: Iterable[Key] = ()) -> None:
        self._keys = [(key.thumbprint(), key) for key in keys]
        self._thumbprints = frozenset(thumbprint for thumbprint, _ in self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    def __contains__(self, thumbprint: str | None) -> bool:
        return thumbprint in self._thumbprints

    def find(self, header: Header) -> tuple[str, Key] | None:
        """Return the key of a JWT and its thumbprint; None if there is none, or if it could be several."""
        kind = KINDS.get(header.algorithm[:2])
        found = [
            (thumbprint, key)
            for thumbprint, key in self._keys
            if key.key_type == kind
            and header.key_id in (None, key.kid)
            and (key.alg is None or key.alg == header.algorithm)
        ]
        return found[0] if len({thumbprint for thumbprint, _ in found}) == 1 else None


def read_keys(document: Mapping[str, Any]) -> Keys:
    """Return the keys of a JWK Set that can verify signatures. Others are left out.

    Raises:
        ValueError: It is not a JWK Set.
    """
    entries = document.get("keys")
    if not isinstance(entries, list) or len(entries) > MAX_KEYS:
        raise ValueError(f"not a list of up to {MAX_KEYS} keys")
    return Keys(key for key in map(_read_key, entries) if key is not None)


def _read_key(entry: object) -> Key | None:
    if not isinstance(entry, dict) or entry.get("kty") not in KINDS.values() or entry.get("use", "sig") != "sig":
        return None
    named = {name: entry[name] for name in ("kid", "alg") if isinstance(entry.get(name), str)}
    parameters = {name: entry[name] for name in ("kty", "crv", "x", "y", "n", "e") if isinstance(entry.get(name), str)}
    try:
        with catch_warnings(action="ignore", category=SecurityWarning):  # that it is too short: see below
            key = import_key({**parameters, **named})
        if not isinstance(key, RSAKey | ECKey | OKPKey):
            return None
        if isinstance(key, RSAKey) and key.public_key.key_size < MIN_RSA_BITS:
            return None
    except (JoseError, ValueError, TypeError, KeyError):
        return None
    return key


def looks_like_jwt(secret: str) -> bool:
    """Return whether a secret can be a JWT, rather than a token of the gateway."""
    return secret.startswith("eyJ") and secret.count(".") == 2


def read_header(token: str) -> Header:
    """Return what a JWT says of its signature.

    Raises:
        NotAuthenticated: It is not a JWT (`invalid_token`).
    """
    fields = _decode_part(token, 0)
    algorithm, key_id, kind = fields.get("alg"), fields.get("kid"), fields.get("typ", "")
    if not isinstance(algorithm, str) or not isinstance(key_id, str | None) or not isinstance(kind, str):
        raise _refusal("it names no algorithm")
    if "crit" in fields:
        raise _refusal("it asks for an extension")
    return Header(algorithm, key_id, kind.lower().removeprefix("application/"))


def read_unverified(token: str) -> Mapping[str, Any]:
    """Return the claims of a JWT without verifying them: only to tell whether it is worth asking for a key.

    Raises:
        NotAuthenticated: It is not a JWT (`invalid_token`).
    """
    return _decode_part(token, 1)


def _decode_part(token: str, index: int) -> Mapping[str, Any]:
    parts = token.split(".")
    if len(token) > MAX_TOKEN or len(parts) != 3:
        raise _refusal("it is not a JWT")
    try:
        fields = orjson.loads(base64.urlsafe_b64decode(parts[index] + "=" * (-len(parts[index]) % 4)))
    except (binascii.Error, ValueError):
        fields = None
    if not isinstance(fields, dict):
        raise _refusal("it is not a JWT")
    return fields


def verify(token: str, keys: Keys, algorithms: Collection[str]) -> Signed:
    """Return the claims of a JWT whose signature is right.

    Args:
        token: The JWT.
        keys: Keys of the provider.
        algorithms: Algorithms that are accepted; at least one.

    Raises:
        NotAuthenticated: The algorithm is not one of them, the key is not known or the signature is wrong
            (`invalid_token`).
    """
    header = read_header(token)
    if header.algorithm not in algorithms:
        raise _refusal(f"its algorithm {header.algorithm[:20]!r} is not accepted")
    found = keys.find(header)
    if found is None:
        raise _refusal("the provider has no such key")
    thumbprint, key = found
    registry = Registry(algorithms=algorithms, strict_check_header=False)
    try:
        claims = jwt.decode(token, key, algorithms, registry).claims
    except (JoseError, ValueError, TypeError, RecursionError):
        raise _refusal("its signature is wrong") from None
    return Signed(claims, thumbprint)


def check_claims(claims: Mapping[str, Any], issuer: str, audience: str, now: datetime) -> datetime:
    """Check from whom a JWT is, for whom, and when; return until when it is valid.

    Raises:
        NotAuthenticated: It is from or for someone else, has expired or is not valid yet (`invalid_token`).
    """
    if claims.get("iss") != issuer:
        raise _refusal("it is from another issuer")
    if audience not in _audiences(claims):
        raise _refusal("it is for another audience")
    at = now.timestamp()
    expires = _seconds(claims, "exp")
    if expires is None:
        raise _refusal("it does not expire")
    if at >= expires + BEHIND:
        raise _refusal("it has expired")
    for name in ("nbf", "iat"):
        begins = _seconds(claims, name)
        if begins is not None and at < begins - AHEAD:
            raise _refusal("it is not valid yet; compare the clocks")
    return datetime.fromtimestamp(expires + BEHIND, UTC)


def require_access_token(header: Header, claims: Mapping[str, Any], client_id: str | None) -> None:
    """Refuse what a provider signs with the same key for another purpose (RFC 8725, 3.11), such as an ID token.

    Few providers call access tokens `at+jwt` as RFC 9068 asks. So another name in the header is refused; with a common
    name, or none, a claim has to say that it is an access token, or no claim may be one of an ID token. A token whose
    audience is the client itself, as that of its ID tokens, needs scopes then.

    Args:
        header: Its header.
        claims: Its claims.
        client_id: The gateway's own name at the provider, if people log in there.

    Raises:
        NotAuthenticated: It is no access token (`invalid_token`).
    """
    uses = [claims[name] for name in USES if name in claims]
    if not all(isinstance(use, str) and use.lower() in ACCESS for use in uses):
        raise _refusal(f"it is no access token: {' or '.join(USES)} says so")
    if header.kind == ACCESS_TOKEN:
        return
    if header.kind not in ANY_KINDS:
        raise _refusal(f"it is no access token but {header.kind[:40]!r}")
    if uses:
        return
    for name in OTHER_CLAIMS:
        if name in claims:
            raise _refusal(f"it is no access token, as it has the claim {name}")
    for_client = client_id is not None and client_id in _audiences(claims)
    if for_client and not any(claims.get(name) for name in SCOPES):
        raise _refusal("it looks like an ID token: it is for the client, and names neither its use nor a scope")


def _audiences(claims: Mapping[str, Any]) -> list[Any]:
    audiences = claims.get("aud")
    return audiences if isinstance(audiences, list) else [audiences]


def _seconds(claims: Mapping[str, Any], name: str) -> float | None:
    """Return a time as seconds since 1970; None if the claim is missing."""
    value = claims.get(name)
    if value is None:
        return None
    if type(value) not in (int, float) or not 0 <= value < END_OF_TIME:  # NaN is not either
        raise _refusal(f"its {name} is not a time")
    return float(value)


def _refusal(reason: str) -> NotAuthenticated:
    return NotAuthenticated(f"the access token is not accepted: {reason}", code="invalid_token")

"""The identity of a user, signed by the hub for one request and verified by the site. The time is given."""

import hashlib
import os
import tempfile
import uuid
from base64 import urlsafe_b64decode
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import orjson
from joserfc import jwt
from joserfc.errors import JoseError
from joserfc.jwk import Key, KeySet, OKPKey
from pydantic import BaseModel, Field, StringConstraints, ValidationError

from dock_gateway.core.errors import NotAuthenticated, TooManyRequests
from dock_gateway.core.grant import MAX_PATTERN, Grant, Role

ISSUER = "dock-gateway-hub"
KIND = "dock-gateway-hub+jwt"
ALGORITHM: Final = "Ed25519"  # and its curve
# Seconds for which a signed identity is valid, and by which the hub's idea of the site's clock may be ahead.
LIFETIME, AHEAD = 60.0, 10.0
MAX_TOKEN = 100_000  # characters
MAX_NAME = 60
# Identities that were used and have not expired yet. More are refused.
MAX_USED = 100_000

Name = Annotated[str, StringConstraints(min_length=1, max_length=MAX_NAME, pattern=r"^[^\p{Cc}\p{Cf}\p{Zl}\p{Zp}]+$")]
Patterns = tuple[Annotated[str, StringConstraints(min_length=1, max_length=MAX_PATTERN)], ...]


def content_of(query: str, body: bytes | None = b"") -> str:
    """Return what is signed of a request besides its method and path: a digest of its query and its body.

    Args:
        query: The query, encoded.
        body: The body; None if it is too long to come with the request.
    """
    return hashlib.sha256(query.encode() if body is None else b"%b\n%b" % (query.encode(), body)).hexdigest()


# The method, in place of one of HTTP, of the public key of a hub: path and content are the two keys.
AGREEMENT: Final = "AGREE"
# Neither a query nor a body.
NOTHING: Final = content_of("")


class KeyFault(Exception):
    """A file of keys cannot be read, made or used. The message is a sentence for who starts the program."""


class IdentityReused(NotAuthenticated):
    """A signed identity was used already: the network has delivered a request twice."""

    code = "identity_reused"


@dataclass(frozen=True)
class Identity:
    """The user who makes a request, as the hub says.

    Attributes:
        name: Their name at the hub; None if the hub needs no login.
        grant: What they may do at the site, in its own names.
        key: Id of the key that has signed it.
        expires_at: Until when this can be used, in seconds since 1970 by the site's clock.
    """

    name: str | None
    grant: Grant
    key: str
    expires_at: float


class _Claims(BaseModel):
    iss: Literal["dock-gateway-hub"]
    aud: str
    instance: str
    sub: Name | None = None
    role: Role
    robots: Patterns
    actions: Patterns
    topics: Patterns
    htm: str
    htu: str
    content: str
    jti: Annotated[str, StringConstraints(min_length=16, max_length=64)]
    iat: Annotated[float, Field(allow_inf_nan=False)]
    exp: Annotated[float, Field(allow_inf_nan=False)]

    @property
    def grant(self) -> Grant:
        return Grant(self.role, self.robots, self.actions, self.topics)


class Signer:
    """The hub's private key.

    Args:
        key: The key.
    """

    def __init__(self, key: OKPKey) -> None:
        self._key = key
        self._header = {"alg": ALGORITHM, "typ": KIND, "kid": key.thumbprint()}

    @classmethod
    def load_or_create(cls, path: Path) -> Self:
        """Read the key, or make one if there is no such file. Only the user can read it.

        Raises:
            KeyFault: It cannot be read or made.
        """
        try:
            if not path.exists():
                _create(path)
            return cls(_read_key(orjson.loads(path.read_bytes()), private=True))
        except OSError as error:
            raise KeyFault(f"the hub's key {path} cannot be read or made: {error.strerror}") from None
        except ValueError:
            raise KeyFault(f"{path} is not the hub's key, which is a private Ed25519 key as a JWK") from None

    def public_keys(self) -> dict[str, Any]:
        """Return the JWK Set that sites verify with."""
        named = {"kid": self._header["kid"], "use": "sig", "alg": ALGORITHM}
        return {"keys": [{**self._key.as_dict(private=False), **named}]}

    def sign(  # noqa: PLR0917 - what a token says
        self,
        site: str,
        instance: str,
        name: str | None,
        grant: Grant,
        method: str,
        path: str,
        now: float,
        *,
        content: str = NOTHING,
        lifetime: float = LIFETIME,
    ) -> str:
        """Return who asks, signed for one request.

        Args:
            site: The site that is asked.
            instance: The process there.
            name: Their name at the hub; None if the hub needs no login.
            grant: What they may do, in the site's own names (`site_grant`).
            method: The request's method.
            path: Its path at the site, without the query.
            now: The time by the site's clock, in seconds since 1970.
            content: Its query and its body (`content_of`).
            lifetime: Seconds after which the site does not begin with the request any more, at most `LIFETIME`.
        """
        claims = {
            "iss": ISSUER,
            "aud": site,
            "instance": instance,
            **({} if name is None else {"sub": name}),
            "role": grant.role,
            "robots": grant.robots,
            "actions": grant.actions,
            "topics": grant.topics,
            "htm": method,
            "htu": path,
            "content": content,
            "jti": uuid.uuid4().hex,
            "iat": now,
            "exp": now + min(lifetime, LIFETIME),
        }
        return jwt.encode(self._header, claims, self._key, [ALGORITHM])


class Verifier:
    """The hub's public keys at a site. It accepts what they have signed for this site, once.

    Args:
        keys: File with a JWK Set: what `dock-gateway hub key` prints at the hub.
        site: Name of the site.

    Raises:
        KeyFault: The file cannot be used.
    """

    def __init__(self, keys: Path, site: str) -> None:
        self._keys = _read_public_keys(keys)
        self._site = site
        self._used: dict[str, float] = {}

    def verify(  # noqa: PLR0917 - what a token says
        self, token: str, instance: str, method: str, path: str, now: float, content: str = NOTHING
    ) -> Identity:
        """Return who asks.

        Args:
            token: What the hub has signed.
            instance: This process.
            method: The method of the request that it came with.
            path: The path of that request, without the query.
            now: The time, in seconds since 1970.
            content: Its query and its body (`content_of`).

        Raises:
            NotAuthenticated: It is not signed by the hub, it is for another site, process or request, or it has expired
                (`invalid_identity`).
            IdentityReused: It was used already.
            TooManyRequests: Too many were used in the last minute.
        """
        if len(token) > MAX_TOKEN:
            raise _refusal("it is too long")
        said = _unverified(token)
        if said is not None:  # a signature takes long to verify: what is refused in any case is refused before
            self._check(said, instance, method, path, now, content)
        claims, key = self._read(token)
        self._check(claims, instance, method, path, now, content)
        self._use(claims, now)
        return Identity(claims.sub, claims.grant, key, claims.exp)

    def _check(  # noqa: PLR0917 - what a token says
        self, claims: _Claims, instance: str, method: str, path: str, now: float, content: str
    ) -> None:
        if (claims.aud, claims.instance) != (self._site, instance):
            raise _refusal("it is for another site, or for another process of this one")
        if (claims.htm, claims.htu, claims.content) != (method, path, content):
            raise _refusal("it is for another request")
        if now >= claims.exp:
            raise _refusal("it has expired")
        if claims.iat > now + AHEAD or claims.exp > claims.iat + LIFETIME:
            raise _refusal("it is not valid yet, or for too long")
        if claims.jti in self._used:
            raise IdentityReused("this request of the hub was received already")

    def _read(self, token: str) -> tuple[_Claims, str]:
        try:
            signed = jwt.decode(token, self._keys, [ALGORITHM])
            claims = _Claims.model_validate(signed.claims)
        except ValidationError:
            raise _refusal("something is missing in it") from None
        except (JoseError, ValueError, TypeError, KeyError, RecursionError):
            raise _refusal("it is not signed with a key of the site's --hub-public-keys") from None
        if signed.header.get("typ") != KIND:
            raise _refusal("it was signed for another purpose")
        return claims, str(signed.header.get("kid"))

    def _use(self, claims: _Claims, now: float) -> None:
        while self._used and (oldest := next(iter(self._used.items())))[1] <= now:
            del self._used[oldest[0]]
        if len(self._used) >= MAX_USED:
            raise TooManyRequests("the hub has sent too many requests in the last minute")
        self._used[claims.jti] = claims.exp


def _unverified(token: str) -> _Claims | None:
    """Return the claims of a token without checking its signature; None if it has none."""
    try:
        _, payload, _ = token.split(".")
        return _Claims.model_validate_json(urlsafe_b64decode(payload + "=" * (-len(payload) % 4)))
    except ValueError:
        return None


def _refusal(reason: str) -> NotAuthenticated:
    return NotAuthenticated(f"who asks is not accepted: {reason}", code="invalid_identity")


def _create(path: Path) -> None:
    """Make a key. If another process makes one at the same time, the first of them stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    key = OKPKey.generate_key(ALGORITHM)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}-") as file:  # mode 600
        file.write(orjson.dumps(key.as_dict(private=True)))
        file.flush()
        os.fsync(file.fileno())
        try:
            os.link(file.name, path)
        except FileExistsError:
            return


def _read_public_keys(path: Path) -> KeySet:
    try:
        entries = orjson.loads(path.read_bytes())["keys"]
        keys: list[Key] = [_read_key(entry, private=False) for entry in entries]
    except OSError as error:
        raise KeyFault(f"hub_public_keys: {path} cannot be read: {error.strerror}") from None
    except (ValueError, TypeError, KeyError):
        keys = []
    if not keys:
        raise KeyFault(
            f"hub_public_keys: {path} is not what `dock-gateway hub key` prints: a JWK Set with Ed25519 keys"
        )
    return KeySet(keys)


def _read_key(entry: Mapping[str, Any], *, private: bool) -> OKPKey:
    """Return a key.

    Raises:
        ValueError: It is not a key, not of the kind that is signed with, or not private though it has to be.
    """
    try:
        parameters = {name: entry[name] for name in ("kty", "crv", "x", "d")[: 4 if private else 3]}
        if parameters["kty"] != "OKP" or parameters["crv"] != ALGORITHM:
            raise ValueError("another kind of key")
        key = OKPKey.import_key(parameters)
        key.ensure_kid()
    except (JoseError, TypeError, KeyError) as error:
        raise ValueError(str(error)) from None
    return key

"""JWTs: who has signed them, for whom, and until when they are valid."""

import hmac
import time
from datetime import UTC, datetime
from typing import Any

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joserfc.jwk import ECKey, OKPKey, RSAKey

from dock_gateway.core.errors import NotAuthenticated
from dock_gateway.extensions.single_sign_on.jwt import (
    AHEAD,
    BEHIND,
    MAX_KEYS,
    Keys,
    check_claims,
    looks_like_jwt,
    read_keys,
    verify,
)
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from tests.extensions.single_sign_on.provider import AUDIENCE, ISSUER, encode, rsa_key, sign
from tests.support.reachable import reachable

ALGORITHMS = SingleSignOnSettings().oidc_algorithms
KEY, OTHER = rsa_key("first"), rsa_key("second")
# An RSA key of 1024 bits.
SHORT = {"kty": "RSA", "kid": "short", "n": encode(((1 << 1023) | 1).to_bytes(128)), "e": "AQAB"}
NOW = datetime(2026, 11, 24, 7, 0, tzinfo=UTC)
AT = NOW.timestamp()
CLAIMS = {"iss": ISSUER, "aud": AUDIENCE, "exp": AT + 60, "sub": "4711"}


def published(*keys: Any, **changes: Any) -> Keys:
    return read_keys({"keys": [{**key.as_dict(private=False), **changes} for key in keys]})


def refusal(token: str, keys: Keys | None = None, algorithms: tuple[str, ...] = ALGORITHMS) -> str:
    with pytest.raises(NotAuthenticated) as refused:
        verify(token, published(KEY) if keys is None else keys, algorithms)
    assert refused.value.code == "invalid_token"
    return refused.value.detail.removeprefix("the access token is not accepted: ")


@pytest.mark.parametrize(
    ("key", "algorithm"),
    [
        (KEY, "RS256"),
        (KEY, "PS256"),
        (ECKey.generate_key("P-256", {"kid": "first"}), "ES256"),
        (OKPKey.generate_key("Ed25519", {"kid": "first"}), "EdDSA"),
        (OKPKey.generate_key("Ed25519", {"kid": "first"}), "Ed25519"),
    ],
)
def test_each_algorithm(key: Any, algorithm: str) -> None:
    token = sign(key, CLAIMS, algorithm)
    signed = verify(token, published(OTHER, key), ALGORITHMS)
    assert signed.claims == CLAIMS
    assert signed.key in published(key)
    assert signed.key not in published(OTHER)
    head, body, signature = token.split(".")
    assert refusal(f"{head}.{encode(CLAIMS | {'sub': 'root'})}.{signature}", published(OTHER, key)) == (
        "its signature is wrong"
    )
    assert looks_like_jwt(token)
    assert body


def test_no_signature_is_none() -> None:
    for algorithm in ("none", "None", "NONE", "nOnE", ""):
        for signature in ("", encode(b"x")):
            token = f"{encode({'alg': algorithm, 'kid': 'first'})}.{encode(CLAIMS)}.{signature}"
            assert "is not accepted" in refusal(token)


@pytest.mark.parametrize("secret", [KEY.as_pem(private=False), orjson.dumps(KEY.as_dict(private=False))])
def test_a_public_key_is_no_shared_secret(secret: bytes) -> None:
    for algorithm in ("HS256", "HS384", "HS512"):
        head, body = encode({"alg": algorithm, "kid": "first"}), encode(CLAIMS)
        signature = hmac.digest(secret, f"{head}.{body}".encode(), f"sha{algorithm[2:]}")
        token = f"{head}.{body}.{encode(signature)}"
        assert "is not accepted" in refusal(token)


def test_another_key_with_the_same_id() -> None:
    assert refusal(sign(rsa_key("first"), CLAIMS)) == "its signature is wrong"


def test_a_key_that_is_not_known() -> None:
    assert refusal(sign(OTHER, CLAIMS)) == "the provider has no such key"
    assert refusal(sign(KEY, CLAIMS), Keys()) == "the provider has no such key"


def test_keys_in_the_token_do_not_count() -> None:
    token = sign(OTHER, CLAIMS, kid="first", jwk=OTHER.as_dict(private=False), jku="https://evil.example/keys")
    assert refusal(token) in ("its signature is wrong", "it is not a JWT")


def test_an_algorithm_that_is_not_configured() -> None:
    assert refusal(sign(KEY, CLAIMS, "RS512")) == "its algorithm 'RS512' is not accepted"
    assert verify(sign(KEY, CLAIMS, "RS512"), published(KEY), ("RS512",)).claims == CLAIMS
    assert refusal(sign(KEY, CLAIMS), algorithms=("ES256",)) == "its algorithm 'RS256' is not accepted"


def test_a_key_is_for_its_algorithm_only() -> None:
    assert refusal(sign(KEY, CLAIMS), published(KEY, alg="PS256")) == "the provider has no such key"
    assert refusal(sign(KEY, CLAIMS), published(KEY, use="enc")) == "the provider has no such key"
    assert verify(sign(KEY, CLAIMS), published(KEY, alg="RS256", use="sig"), ALGORITHMS).claims == CLAIMS


def test_without_an_id_there_must_be_one_key_only() -> None:
    token = sign(KEY, CLAIMS, kid=None)
    elliptic = ECKey.generate_key("P-256", {"kid": "ec"})
    assert verify(token, published(KEY, elliptic), ALGORITHMS).claims == CLAIMS
    assert refusal(token, published(KEY, OTHER)) == "the provider has no such key"


def test_critical_extensions_are_refused() -> None:
    for extension in ({"crit": ["exp"], "exp": 1}, {"crit": ["b64"], "b64": False}, {"crit": []}, {"crit": None}):
        head = encode({"alg": "RS256", "kid": "first", **extension})
        token = f"{head}.{encode(CLAIMS)}.{encode(b'x')}"
        assert refusal(token) == "it asks for an extension"


@given(st.text(max_size=80) | st.tuples(st.binary(), st.binary(), st.binary()).map(lambda p: ".".join(map(encode, p))))
def test_anything_else_is_refused(token: str) -> None:
    refusal(token)
    refusal(f"eyJ.{token}")


@pytest.mark.parametrize(
    "token",
    ["a.b", "..", "a.b.c.d", f"{encode([])}.{encode({})}.", f"{encode({'alg': 'RS256', 'kid': 1})}.e30.", "x" * 20_000],
)
def test_what_is_no_jwt(token: str) -> None:
    assert refusal(token)


def test_nested_deeply() -> None:
    token = f"{encode(b'[' * 6000)}.{encode(CLAIMS)}."
    assert refusal(token) == "it is not a JWT"
    keys = published(KEY)
    deep = b'{"a":' + b"[" * 5000 + b"]" * 5000 + b"}"
    head = sign(KEY, CLAIMS).split(".")[0]
    assert refusal(f"{head}.{encode(deep)}.{encode(b'x')}", keys) == "its signature is wrong"


def test_what_is_published_may_hold_anything() -> None:
    junk: list[Any] = [None, [], {}, {"kty": "RSA"}, {"kty": "oct", "k": "c2VjcmV0", "kid": "first"}, {"kty": []}]
    junk += [{"kty": "EC", "crv": "P-256", "x": "!", "y": "!"}, {"kty": "RSA", "n": "AQAB", "e": "AQAB", "kid": "x"}]
    keys = read_keys({"keys": [*junk, KEY.as_dict(private=True), SHORT]})
    assert len(keys) == 1
    assert verify(sign(KEY, CLAIMS), keys, ALGORITHMS).claims == CLAIMS


@pytest.mark.parametrize("document", [{}, {"keys": {}}, {"keys": "x"}, {"keys": [{}] * (MAX_KEYS + 1)}])
def test_what_is_no_set_of_keys(document: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="keys"):
        read_keys(document)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"iss": "https://evil.example"}, "another issuer"),
        ({"iss": f"{ISSUER}/"}, "another issuer"),
        ({"iss": None}, "another issuer"),
        ({"iss": [ISSUER]}, "another issuer"),
        ({"aud": "dashboard"}, "another audience"),
        ({"aud": [f"{AUDIENCE}/", "x"]}, "another audience"),
        ({"aud": None}, "another audience"),
        ({"aud": {AUDIENCE: 1}}, "another audience"),
        ({"exp": None}, "does not expire"),
        ({"exp": AT - BEHIND}, "has expired"),
        ({"exp": 0}, "has expired"),
        ({"exp": "2099-01-01"}, "exp is not a time"),
        ({"exp": True}, "exp is not a time"),
        ({"exp": 1e400}, "exp is not a time"),
        ({"exp": 10**400}, "exp is not a time"),
        ({"nbf": AT + AHEAD + 1}, "not valid yet"),
        ({"nbf": "now"}, "nbf is not a time"),
        ({"iat": AT + AHEAD + 1}, "not valid yet"),
    ],
)
def test_claims_that_are_refused(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(NotAuthenticated, match=reason) as refused:
        check_claims({**CLAIMS, **changes}, ISSUER, AUDIENCE, NOW)
    assert refused.value.code == "invalid_token"


@pytest.mark.parametrize(
    "changes",
    [{}, {"aud": ["x", AUDIENCE]}, {"exp": AT - BEHIND + 0.1}, {"nbf": AT + AHEAD - 1, "iat": AT + AHEAD - 1}],
)
def test_claims_that_are_accepted(changes: dict[str, Any]) -> None:
    claims = {**CLAIMS, **changes}
    until = check_claims(claims, ISSUER, AUDIENCE, NOW)
    assert until.timestamp() == pytest.approx(float(str(claims["exp"])) + BEHIND)


def test_verifying_takes_no_time_that_the_event_loop_would_notice() -> None:
    keys, token = published(*(rsa_key(str(number)) for number in range(5)), KEY), sign(KEY, CLAIMS)
    began = time.process_time()
    for _ in range(100):
        verify(token, keys, ALGORITHMS)
    assert time.process_time() - began < 100 * 0.002


def test_private_parts_are_not_kept() -> None:
    assert isinstance(KEY, RSAKey)
    keys = read_keys({"keys": [KEY.as_dict(private=True)]})
    assert [key.is_private for key in reachable(keys, RSAKey)] == [False]
    assert KEY.as_dict(private=True)["d"] not in reachable(keys, str)

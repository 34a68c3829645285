"""Which of the JWTs that a provider signs with one key are access tokens: of any provider, with any claims."""

import json
import time
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from joserfc.jwk import ECKey

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, NotAuthenticated
from dock_gateway.extensions.single_sign_on.jwt import SCOPES, USES, read_keys
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from dock_gateway.extensions.single_sign_on.single_sign_on import SingleSignOn
from tests.extensions.single_sign_on.provider import AUDIENCE, CLIENT, ISSUER, sign

KEY = ECKey.generate_key("P-256", {"kid": "first"})
NOW = int(time.time())
Claims = dict[str, Any]


def provider(client_id: str | None = CLIENT) -> SingleSignOn:
    settings = SingleSignOnSettings(  # type: ignore[call-arg]
        oidc_issuer=ISSUER,
        oidc_client_id=client_id,
        oidc_audience=AUDIENCE,
        oidc_roles=("ops=operator",),  # type: ignore[arg-type]
    )
    sso = SingleSignOn(settings)
    sso.provider.keys = read_keys({"keys": [KEY.as_dict(private=False)]})
    return sso


SSO = provider()
# For the gateway, and for the dashboard's client, too.
BOTH = [CLIENT, AUDIENCE]


def identify(claims: Claims, kind: str | None, sso: SingleSignOn = SSO) -> Principal:
    return sso.identify(sign(KEY, claims, "ES256", typ=kind))


def refusal(claims: Claims, kind: str | None = None) -> str:
    with pytest.raises(NotAuthenticated) as refused:
        identify(claims, kind)
    assert refused.value.code == "invalid_token"
    return refused.value.detail


# ---------------------------------------------------------------------- what no provider signs as an access token

NAMES = st.text(st.characters(codec="ascii", categories=["L", "N"]), min_size=1, max_size=10)
REQUIRED = {"iss": ISSUER, "exp": NOW + 36_000, "iat": NOW, "sub": "4711", "roles": ["ops"]}
# What OpenID Connect Core, the front and back channels and FAPI define, and what providers add.
OF_ID_TOKENS: dict[str, st.SearchStrategy[Any]] = {
    "nonce": NAMES,
    "at_hash": NAMES,
    "c_hash": NAMES,
    "s_hash": NAMES,
    "auth_time": st.just(NOW),
    "acr": NAMES,
    "amr": st.lists(NAMES, max_size=2),
    "azp": st.sampled_from([CLIENT, "another"]),
    "sid": NAMES,
    "jti": NAMES,
    "client_id": st.just(CLIENT),
    "preferred_username": NAMES,
    "email": NAMES,
    "email_verified": st.booleans(),
    "groups": st.lists(NAMES, max_size=2),
    "act": st.fixed_dictionaries({"sub": NAMES}),
    "nbf": st.just(NOW),
}
OTHERS_USES = st.sampled_from(["ID", "id", "id_token", "Refresh", "Offline", "Logout", "DPoP", "", 1, None, ["Bearer"]])
OTHERS_KINDS = ["id_token+jwt", "logout+jwt", "secevent+jwt", "rt+jwt", "token-introspection+jwt", "at+jwt2", "ID"]


@given(
    claims=st.fixed_dictionaries({}, optional=OF_ID_TOKENS),
    more=st.lists(st.sampled_from(["account", "another"]), max_size=1),
    kind=st.sampled_from([None, "JWT", "jwt"]),
)
@example(claims={}, more=[], kind=None)
@example(claims={"nonce": "x"}, more=[], kind="JWT")
@example(claims={"azp": "another", "preferred_username": "ada"}, more=[], kind="JWT")
def test_no_id_token_of_this_client_is_an_access_token(claims: Claims, more: list[str], kind: str | None) -> None:
    """Also one that is for the gateway's audience besides, as a provider's mapper may add it."""
    refusal({**REQUIRED, **claims, "aud": [*BOTH, *more]}, kind)
    refusal({**REQUIRED, **claims, "aud": CLIENT}, kind)


@given(
    use=st.dictionaries(st.sampled_from(USES), OTHERS_USES, min_size=1),
    kind=st.sampled_from([None, "JWT", "at+jwt"]),
)
def test_what_is_named_for_another_use(use: Claims, kind: str | None) -> None:
    assert "says so" in refusal({**REQUIRED, "aud": BOTH, "scope": "robots", **use}, kind)


@pytest.mark.parametrize("kind", OTHERS_KINDS)
def test_what_is_another_kind_of_jwt(kind: str) -> None:
    claims = {**REQUIRED, "aud": AUDIENCE, "typ": "Bearer", "scope": "robots"}
    assert f"but {kind.lower()!r}" in refusal(claims, kind)


@pytest.mark.parametrize("name", ["nonce", "at_hash", "c_hash", "s_hash", "events"])
@pytest.mark.parametrize("value", ["x", None, False, {}])
def test_claims_of_other_tokens(name: str, value: Any) -> None:
    assert name in refusal({**REQUIRED, "aud": AUDIENCE, "scope": "robots", name: value})


@pytest.mark.parametrize("kind", [None, "JWT", "at+jwt"])
def test_there_must_be_a_subject(kind: str | None) -> None:
    claims = {**REQUIRED, "aud": AUDIENCE, "preferred_username": "ada", "azp": "fleet", "typ": "Bearer"}
    for sub in (None, "", 4711, ["4711"], True, "x" * 256, "a\nb"):
        assert "sub" in refusal({**claims, "sub": sub}, kind)
    del claims["sub"]
    assert "sub" in refusal(claims, kind)


# ---------------------------------------------------------------------- what is one

KINDS = st.sampled_from(["at+jwt", "AT+JWT", "application/at+jwt", "Application/at+JWT"])
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)
# RFC 9068, 2.2; RFC 8693, 4; RFC 9449, 6; and whatever a provider adds.
OF_ACCESS_TOKENS = {
    **{name: OF_ID_TOKENS[name] for name in ("auth_time", "acr", "amr", "groups", "nbf", "act")},
    "scope": st.sampled_from(["", "robots", "openid profile"]),
    "entitlements": st.lists(NAMES, max_size=2),
    "cnf": st.fixed_dictionaries({"jkt": NAMES}),
    "may_act": st.fixed_dictionaries({"sub": NAMES}),
    "preferred_username": NAMES,
    "nonce": JSON,
    "sid": JSON,
    "events": JSON,
}
READ = {"iss", "aud", "exp", "sub", "iat", "nbf", "roles", "preferred_username", *USES}


@given(
    kind=KINDS,
    claims=st.fixed_dictionaries({"client_id": NAMES, "jti": NAMES}, optional=OF_ACCESS_TOKENS),
    more=st.lists(NAMES | st.just(CLIENT), max_size=2),
    further=st.dictionaries(NAMES.filter(lambda name: name not in READ), JSON, max_size=3),
    subject=NAMES,
)
def test_every_access_token_by_the_standard_is_one(
    kind: str, claims: Claims, more: list[str], further: Claims, subject: str
) -> None:
    aud = [*more, AUDIENCE] if more else AUDIENCE
    principal = identify({**further, **REQUIRED, **claims, "sub": subject, "aud": aud}, kind)
    assert principal.name == f"oidc:{claims.get('preferred_username', subject)}"


# Tokens as these providers document them, shortened: an access token, and the ID token of the same login.
PROVIDERS: dict[str, tuple[str | None, Claims, Claims]] = {
    "Keycloak 26": (
        "JWT",
        {"typ": "Bearer", "azp": "fleet", "sid": "x", "acr": "1", "scope": "profile", "allowed-origins": ["/*"]},
        {"typ": "ID", "azp": CLIENT, "sid": "x", "acr": "1", "at_hash": "x", "nonce": "x", "auth_time": NOW},
    ),
    "Keycloak 20": (
        "JWT",
        {"typ": "Bearer", "azp": CLIENT, "nonce": "x", "session_state": "x", "auth_time": NOW, "scope": "openid"},
        {"typ": "ID", "azp": CLIENT, "nonce": "x", "session_state": "x", "auth_time": NOW},
    ),
    "Entra ID, a person": (
        "JWT",
        {"azp": "fleet", "azpacr": "1", "scp": "access_as_user", "oid": "x", "tid": "x", "uti": "x", "ver": "2.0"},
        {"oid": "x", "tid": "x", "uti": "x", "ver": "2.0", "nonce": "x", "rh": "x", "preferred_username": "ada"},
    ),
    "Entra ID, a service": (
        "JWT",
        {"azp": "fleet", "azpacr": "2", "oid": "x", "tid": "x", "uti": "x", "ver": "2.0"},
        {"oid": "x", "tid": "x", "uti": "x", "ver": "2.0"},
    ),
    "Okta": (
        None,
        {"ver": 1, "jti": "AT.x", "cid": "fleet", "uid": "x", "scp": ["robots"], "auth_time": NOW},
        {"ver": 1, "jti": "ID.x", "amr": ["pwd"], "idp": "x", "auth_time": NOW, "at_hash": "x"},
    ),
    "Auth0": ("at+jwt", {"client_id": "fleet", "jti": "x", "scope": "robots"}, {"sid": "x", "nonce": "x"}),
    "authentik": (
        "JWT",
        {"azp": CLIENT, "uid": "x", "scope": "openid", "auth_time": NOW, "acr": "x", "sid": "x"},
        {"at_hash": "x", "nonce": "x", "auth_time": NOW, "acr": "x", "sid": "x"},
    ),
    "Spring Authorization Server": (
        None,
        {"scope": ["robots"], "nbf": NOW, "jti": "x"},
        {"azp": CLIENT, "auth_time": NOW, "jti": "x", "sid": "x"},
    ),
    "Duende IdentityServer": (
        "at+jwt",
        {"client_id": "fleet", "scope": ["robots"], "jti": "x", "nbf": NOW, "auth_time": NOW, "idp": "local"},
        {"at_hash": "x", "sid": "x", "auth_time": NOW, "idp": "local", "amr": ["pwd"]},
    ),
    "Amazon Cognito": (None, {"token_use": "access", "client_id": "fleet"}, {"token_use": "id", "event_id": "x"}),
}


@pytest.mark.parametrize("name", PROVIDERS)
def test_the_tokens_of_providers(name: str) -> None:
    kind, access, identity = PROVIDERS[name]
    for audiences in (AUDIENCE, BOTH):
        assert identify({**REQUIRED, "aud": audiences, **access}, kind).name == "oidc:4711"
    for audiences in (CLIENT, BOTH):
        refusal({**REQUIRED, "aud": audiences, **identity}, None if kind is None else "JWT")


def test_a_service_whose_token_says_little() -> None:
    """Auth0 without a profile: for an API, which no ID token is for."""
    claims = {**REQUIRED, "azp": "fleet", "gty": "client-credentials"}
    assert identify({**claims, "aud": AUDIENCE}, "JWT")
    assert identify({**claims, "aud": [None, AUDIENCE]}, "JWT", provider(None))
    assert "looks like an ID token" in refusal({**claims, "aud": BOTH}, "JWT")


# ---------------------------------------------------------------------- odd values

ODD = st.sampled_from([
    "NaN", "Infinity", "-Infinity", "1e400", "-1e400", "1" + "0" * 400, "-1", "0", "true", "false", "null", '""',
    "[]", "{}", "[[]]", '"x"', "4711", '["x"]', '{"x": 1}', '"\\ud800"', '"\\u0000"', "1.5", "[NaN]", '[{"a": []}]',
])  # fmt: skip
CLAIMS = sorted({*REQUIRED, "aud", "nbf", "preferred_username", "scope", "act", *OF_ID_TOKENS, *USES, *SCOPES})


@given(odd=st.dictionaries(st.sampled_from(CLAIMS), ODD, min_size=1, max_size=3), kind=KINDS | st.none())
@example(odd={"exp": "NaN"}, kind=None)
@example(odd={"sub": "4711", "preferred_username": '"ada"'}, kind="at+jwt")
def test_odd_values_are_refused_or_harmless(odd: dict[str, str], kind: str | None) -> None:
    claims: Claims = {**REQUIRED, "aud": AUDIENCE, "scope": "robots"}
    text = {name: json.dumps(value) for name, value in claims.items()} | odd
    payload = "{" + ",".join(f"{json.dumps(name)}:{value}" for name, value in text.items()) + "}"
    token = sign(KEY, payload.encode(), "ES256", typ=kind)
    try:
        principal = SSO.identify(token)
    except GatewayError as error:
        assert error.code in ("invalid_token", "role_required")  # noqa: PT017 - any other error fails the test
        return
    assert text["iss"] == json.dumps(ISSUER)
    assert text["aud"] == json.dumps(AUDIENCE)
    assert text["exp"] == json.dumps(NOW + 36_000)
    assert isinstance(json.loads(text["sub"]), str)
    assert principal.name is not None
    assert principal.name.isprintable()
    assert principal.grant.role == "operator"

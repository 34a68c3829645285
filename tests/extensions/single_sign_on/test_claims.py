"""Names and grants from claims: nobody gets more than the claims say, and nothing by default."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.access.users import USER_NAME
from dock_gateway.core.errors import NotAllowed, NotAuthenticated
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.single_sign_on.claims import MAX_NAME, ClaimRules
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from tests.extensions.single_sign_on.provider import CLIENT, ISSUER

BASE = {"oidc_issuer": ISSUER, "oidc_client_id": CLIENT}
ROLES = ("ops=operator", "leads=supervisor", "cn=admins=admin", " watch = viewer ")
JSON = st.recursive(st.none() | st.booleans() | st.integers() | st.text(max_size=9), st.lists, max_leaves=5)


def rules(**settings: Any) -> ClaimRules:
    return ClaimRules(SingleSignOnSettings(**{**BASE, "oidc_roles": ROLES, **settings}))


@pytest.mark.parametrize(
    ("claims", "role"),
    [
        ({"roles": "ops"}, Role.OPERATOR),
        ({"roles": ["ops"]}, Role.OPERATOR),
        ({"roles": ["leads", "ops", "unknown", 7, None]}, Role.SUPERVISOR),
        ({"roles": ["ops", "cn=admins"]}, Role.ADMIN),
        ({"roles": "watch"}, Role.VIEWER),
        ({}, None),
        ({"roles": []}, None),
        ({"roles": None}, None),
        ({"roles": ["OPS"]}, None),
        ({"roles": ["operator", "admin", "cn"]}, None),
        ({"roles": "ops leads"}, None),
        ({"roles": {"ops": True}}, None),
        ({"roles": [["ops"]]}, None),
        ({"groups": ["ops"]}, None),
    ],
)
def test_roles(claims: dict[str, Any], role: Role | None) -> None:
    if role is not None:
        assert rules().grant_of(claims) == Grant(role)
        return
    with pytest.raises(NotAllowed) as refused:
        rules().grant_of(claims)
    assert refused.value.code == "role_required"


@given(st.dictionaries(st.sampled_from(["sub", "role", "groups", "roles"]), JSON))
def test_other_claims_give_no_role(claims: dict[str, Any]) -> None:
    claims.pop("roles", None)
    with pytest.raises(NotAllowed):
        rules().grant_of(claims)


@pytest.mark.parametrize(
    ("claim", "claims"),
    [
        ("realm_access.roles", {"realm_access": {"roles": ["ops"]}}),
        ("https://example.com/roles", {"https://example.com/roles": ["ops"]}),
        ("scope", {"scope": "openid ops"}),
        ("a.b", {"a.b": "ops", "a": {"b": "leads"}}),
    ],
)
def test_where_roles_are(claim: str, claims: dict[str, Any]) -> None:
    assert rules(oidc_role_claim=claim).grant_of(claims) == Grant(Role.OPERATOR)
    with pytest.raises(NotAllowed):
        rules(oidc_role_claim=claim).grant_of({"realm_access": ["roles"], "scope": "opsx"})


def test_limits() -> None:
    limited = rules(oidc_robots_claim="robots", oidc_actions_claim="permissions.actions")
    claims = {"roles": "ops", "robots": ["/hall_a/*", "/hall_a/*"], "permissions": {"actions": "*/dock"}}
    assert limited.grant_of(claims) == Grant(Role.OPERATOR, ("/hall_a/*",), ("*/dock",))
    assert limited.grant_of({"roles": "cn=admins"}) == Grant(Role.ADMIN)


@pytest.mark.parametrize(
    "robots", [None, [], "", "*", "robot1", ["/a", "b"], ["/a", 1], {"/a": 1}, ["/a"] * 51, ["/" + "a" * 255], ["/a\n"]]
)
def test_a_limit_that_is_not_valid_lets_nobody_in(robots: Any) -> None:
    limited = rules(oidc_robots_claim="robots")
    for claims in ({"roles": "ops", "robots": robots}, {"roles": "ops"}):
        with pytest.raises(NotAllowed) as refused:
            limited.grant_of(claims)
        assert refused.value.code == "role_required"


@given(st.text(min_size=1, max_size=100))
def test_no_name_is_that_of_a_user_and_all_fit_in_a_record(text: str) -> None:
    try:
        name = rules().name_of({"sub": "4711", "preferred_username": text})
    except NotAuthenticated:
        assert not text.strip() or not text.isprintable()
        return
    assert name.startswith("oidc:")
    assert len(name) <= MAX_NAME
    assert not USER_NAME.fullmatch(name)


def test_names() -> None:
    assert rules().name_of({"sub": "4711", "preferred_username": "ada"}) == "oidc:ada"
    assert rules().name_of({"sub": "4711"}) == "oidc:4711"
    assert rules(oidc_name_claim="sub").name_of({"sub": "4711", "preferred_username": "ada"}) == "oidc:4711"
    long = [rules().name_of({"preferred_username": "a" * 80 + end}) for end in "bc"]
    assert long[0] != long[1]
    for claims in ({}, {"sub": 4711}, {"preferred_username": ["ada"]}, {"preferred_username": "\u202eada"}):
        with pytest.raises(NotAuthenticated):
            rules().name_of(claims)

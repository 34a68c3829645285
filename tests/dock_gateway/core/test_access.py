"""Each role includes the ones before it; a token is valid until it expires."""

from datetime import UTC, datetime, timedelta

import pytest

from dock_gateway.core.access import Role, Token

NOW = datetime(2026, 11, 23, 22, 0, tzinfo=UTC)


@pytest.mark.parametrize(
    ("role", "included"),
    [
        (Role.VIEWER, {"viewer"}),
        (Role.OPERATOR, {"viewer", "operator"}),
        (Role.SUPERVISOR, {"viewer", "operator", "supervisor"}),
        (Role.ADMIN, {"viewer", "operator", "supervisor", "admin"}),
    ],
)
def test_roles_include_those_before(role: Role, included: set[str]) -> None:
    assert {each.value for each in Role if role.includes(each)} == included


@pytest.mark.parametrize(("lifetime", "valid"), [(None, True), (timedelta(seconds=1), True), (timedelta(0), False)])
def test_a_token_is_valid_until_it_expires(lifetime: timedelta | None, valid: bool) -> None:
    token = Token("ada", Role.VIEWER, "", None, NOW, None if lifetime is None else NOW + lifetime, None)
    assert token.valid(NOW) is valid

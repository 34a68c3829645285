"""A token is valid until it expires; whose an idempotency key is."""

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.access import ANYBODY, Principal, PrincipalKind, Token
from dock_gateway.core.grant import Grant, Role

NOW = datetime(2026, 11, 23, 22, 0, tzinfo=UTC)


@pytest.mark.parametrize(("lifetime", "valid"), [(None, True), (timedelta(seconds=1), True), (timedelta(0), False)])
def test_a_token_is_valid_until_it_expires(lifetime: timedelta | None, valid: bool) -> None:
    expires_at = None if lifetime is None else NOW + lifetime
    token = Token("ada", Role.VIEWER, (), (), (), "", None, NOW, expires_at, None)
    assert token.valid(NOW) is valid


@given(st.text(max_size=60), st.text(min_size=1, max_size=200), st.text(max_size=60), st.text(min_size=1, max_size=200))
def test_an_idempotency_key_is_of_who_sends_it(name: str, key: str, other_name: str, other_key: str) -> None:
    """Whatever login they use, and with whatever role; no other name and key are the same one."""
    first = Principal(name, PrincipalKind.USER, Grant(Role.OPERATOR), "first")
    later = Principal(name, PrincipalKind.USER, Grant(Role.ADMIN), "another session")
    other = Principal(other_name, PrincipalKind.TOKEN, Grant(Role.ADMIN), "id")
    assert first.own(key) == later.own(key)
    assert (first.own(key) == other.own(other_key)) is ((name, key) == (other_name, other_key))
    assert len(first.own(key)) == 64
    assert ANYBODY.own(key) == key  # as it was always stored

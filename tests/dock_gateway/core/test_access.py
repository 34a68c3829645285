"""A token is valid until it expires."""

from datetime import UTC, datetime, timedelta

import pytest

from dock_gateway.core.access import Token
from dock_gateway.core.grant import Role

NOW = datetime(2026, 11, 23, 22, 0, tzinfo=UTC)


@pytest.mark.parametrize(("lifetime", "valid"), [(None, True), (timedelta(seconds=1), True), (timedelta(0), False)])
def test_a_token_is_valid_until_it_expires(lifetime: timedelta | None, valid: bool) -> None:
    expires_at = None if lifetime is None else NOW + lifetime
    token = Token("ada", Role.VIEWER, (), (), (), "", None, NOW, expires_at, None)
    assert token.valid(NOW) is valid

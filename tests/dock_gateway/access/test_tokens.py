"""Tokens: who shows which, what is stored of them, and how soon a revocation is known everywhere.

test_logins.py has the streams that end with them.
"""

from dataclasses import replace
from datetime import timedelta

import pytest

from dock_gateway.access.credentials import ID_DIGITS, digest_of
from dock_gateway.access.tokens import Tokens
from dock_gateway.core.access import Token
from dock_gateway.core.errors import Conflict, NotAuthenticated, NotFound, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.storage.shared_entries import SharedBook
from tests.support.entries import SharedStore


class Site:
    """Gateways that share their history."""

    def __init__(self) -> None:
        self.store: SharedStore[Token] = SharedStore()

    def tokens(self, most: int = 10) -> Tokens:
        return Tokens(SharedBook(self.store, "token", most))

    async def stored(self) -> list[Token]:
        return list((await self.store.read()).values())

    async def change(self, secret: str, **fields: object) -> None:
        token_id = digest_of(secret)[:ID_DIGITS]
        (token,) = await self.stored()
        await self.store.write(token_id, replace(token, **fields))  # type: ignore[arg-type]


@pytest.fixture
def site() -> Site:
    return Site()


async def test_a_token_says_who_shows_it(site: Site) -> None:
    tokens = site.tokens()
    document, secret = await tokens.create("ada", Grant(Role.OPERATOR), by="root")
    principal = tokens.identify(secret)
    assert (principal.name, principal.grant.role, principal.credential) == ("ada", Role.OPERATOR, document["id"])
    assert secret.startswith("dgw_")
    assert len(secret) == len("dgw_") + 43
    assert {"digest", "secret"}.isdisjoint(document)
    (stored,) = await site.stored()
    assert secret not in repr(stored)
    assert stored.created_by == "root"


@pytest.mark.parametrize("secret", ["", "dgw_", "dgw_wrong", "\udcff\U0001f511", "x" * 100_000])
async def test_any_other_secret_is_refused(site: Site, secret: str) -> None:
    tokens = site.tokens()
    await tokens.create("ada", Grant(Role.ADMIN))
    with pytest.raises(NotAuthenticated) as refused:
        tokens.identify(secret)
    assert refused.value.code == "invalid_token"


async def test_the_whole_digest_counts(site: Site) -> None:
    """Not the digits of the id alone, for which a second secret could be found."""
    tokens = site.tokens()
    _, secret = await tokens.create("ada", Grant(Role.ADMIN))
    await site.change(secret, digest=digest_of(secret)[:ID_DIGITS] + "0" * 48)
    await tokens.refresh()
    with pytest.raises(NotAuthenticated):
        tokens.identify(secret)


async def test_an_expired_token_is_refused(site: Site) -> None:
    tokens = site.tokens()
    _, secret = await tokens.create("ada", Grant(Role.ADMIN), utc_now() + timedelta(days=1))
    assert tokens.have_admin()
    await site.change(secret, expires_at=utc_now() - timedelta(seconds=1))
    await tokens.refresh()
    assert not tokens.have_admin()
    with pytest.raises(NotAuthenticated):
        tokens.identify(secret)
    assert [token["valid"] for token in await tokens.documents()] == [False]


async def test_a_revocation_is_known_at_once_here_and_soon_elsewhere(site: Site) -> None:
    here, elsewhere = site.tokens(), site.tokens()
    document, secret = await here.create("ada", Grant(Role.ADMIN))
    await elsewhere.refresh()
    await here.book.remove(document["id"])
    assert elsewhere.principal(document["id"]) is not None
    await elsewhere.refresh()
    for tokens in (here, elsewhere):
        assert tokens.principal(document["id"]) is None
        with pytest.raises(NotAuthenticated):
            tokens.identify(secret)
    with pytest.raises(NotFound, match="there is no token"):
        await elsewhere.book.remove(document["id"])


async def test_the_use_of_a_token_does_not_bring_it_back(site: Site) -> None:
    here, elsewhere = site.tokens(), site.tokens()
    document, secret = await here.create("ada", Grant(Role.ADMIN))
    await elsewhere.refresh()
    elsewhere.identify(secret)
    await here.book.remove(document["id"])
    await elsewhere.refresh()
    assert await site.stored() == []


async def test_its_use_is_recorded_once_a_minute(site: Site) -> None:
    tokens = site.tokens()
    _, secret = await tokens.create("ada", Grant(Role.ADMIN))
    tokens.identify(secret)
    await tokens.refresh()
    (first,) = await site.stored()
    assert first.used_at is not None
    tokens.identify(secret)
    await tokens.refresh()
    assert await site.stored() == [first]
    await site.change(secret, used_at=first.used_at - timedelta(minutes=2))
    await tokens.refresh()
    tokens.identify(secret)
    await tokens.refresh()
    (later,) = await site.stored()
    assert later.used_at is not None
    assert later.used_at >= first.used_at


async def test_known_tokens_stay_valid_while_the_history_is_away(site: Site) -> None:
    tokens = site.tokens()
    _, secret = await tokens.create("ada", Grant(Role.ADMIN))
    site.store.away = True
    tokens.identify(secret)
    await tokens.refresh()
    assert tokens.identify(secret).name == "ada"
    with pytest.raises(Unavailable):
        await tokens.create("eve", Grant(Role.VIEWER))
    with pytest.raises(Unavailable):
        await tokens.book.remove(digest_of(secret)[:ID_DIGITS])
    assert tokens.identify(secret).name == "ada"


async def test_names_are_used_once_and_tokens_are_limited(site: Site) -> None:
    tokens = site.tokens(most=2)
    await tokens.create("ada", Grant(Role.ADMIN))
    with pytest.raises(Conflict) as taken:
        await site.tokens().create("ada", Grant(Role.VIEWER))
    assert taken.value.code == "token_exists"
    await tokens.create("bob", Grant(Role.VIEWER))
    with pytest.raises(Conflict) as full:
        await tokens.create("eve", Grant(Role.VIEWER))
    assert full.value.code == "limit_reached"
    assert [token["name"] for token in await tokens.documents()] == ["ada", "bob"]

"""A request of a person or a service of the provider whose body is held back: it acts with the login of that moment."""

import time
from collections.abc import AsyncIterator

import orjson
import pytest

from dock_gateway.extensions.single_sign_on import provider as provider_module
from dock_gateway.extensions.single_sign_on.jwt import BEHIND
from dock_gateway.extensions.single_sign_on.logins import ProviderLogins
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from dock_gateway.extensions.single_sign_on.single_sign_on import SingleSignOn
from tests.extensions.single_sign_on.provider import FakeProvider, oidc_settings
from tests.support.held_back import Site
from tests.support.waiting import until

CALLBACK = "https://robots.example/session/oidc/callback"
People = tuple[Site, ProviderLogins, FakeProvider]

pytestmark = pytest.mark.usefixtures("quick_hashes")


@pytest.fixture
async def people(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[People]:
    """A site where admins of an identity provider log in."""
    fake = FakeProvider()
    fake.claims["roles"] = ["admins"]
    monkeypatch.setattr(provider_module, "_client", fake.client)
    site = Site()
    settings = SingleSignOnSettings(**oidc_settings(fake.issuer))  # type: ignore[arg-type]
    elsewhere = ProviderLogins(site.history, site.logins.guard, SingleSignOn(settings))
    with site.logins.sources.adding(elsewhere):
        yield site, elsewhere, fake
    await elsewhere.close()
    await site.logins.close()


async def test_a_person_of_a_provider_who_is_logged_out_while_a_body_comes(people: People) -> None:
    site, elsewhere, fake = people
    address, attempt = await elsewhere.begin("/", CALLBACK)
    _, site.secret = await elsewhere.log_in(attempt, fake.authorize(address), CALLBACK, "192.0.2.1")

    async def end(site: Site) -> None:
        await site.logins.log_out_person("oidc:ada")

    body = orjson.dumps({"name": "x", "role": "admin"})
    assert await site.ask("POST", "/tokens", body, meanwhile=end) == (401, "invalid_token")
    assert await site.logins.tokens.documents() == []


async def test_an_access_token_of_a_provider_that_expires_while_a_body_comes(
    people: People,
) -> None:
    site, _, fake = people
    expires = time.time() - BEHIND + 0.5
    site.secret = fake.access_token(exp=expires)

    async def expire(_: Site) -> None:
        await until(lambda: time.time() >= expires + BEHIND)

    body = orjson.dumps({"name": "x", "role": "admin"})
    assert await site.ask("POST", "/tokens", body, meanwhile=expire) == (401, "invalid_token")
    assert await site.logins.tokens.documents() == []
    site.secret = fake.access_token()
    assert await site.ask("POST", "/tokens", body) == (201, None)

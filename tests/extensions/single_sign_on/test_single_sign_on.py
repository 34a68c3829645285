"""Logins with an identity provider: who gets in, and who does not, whatever the provider or a browser says."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx2
import pytest

from dock_gateway.access.credentials import ID_DIGITS, digest_of
from dock_gateway.access.logins import Logins
from dock_gateway.access.sessions import MAX_PER_USER
from dock_gateway.core.access import PrincipalKind
from dock_gateway.core.errors import GatewayError, NotAuthenticated, NotFound, Unavailable
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.single_sign_on import provider as provider_module
from dock_gateway.extensions.single_sign_on.jwt import BEHIND
from dock_gateway.extensions.single_sign_on.login_attempt import LIFETIME, LoginAttempt, is_page
from dock_gateway.extensions.single_sign_on.logins import ProviderLogins
from dock_gateway.extensions.single_sign_on.provider import PAUSE, RECENT, Provider
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from dock_gateway.extensions.single_sign_on.single_sign_on import SingleSignOn
from dock_gateway.storage import History
from tests.extensions.single_sign_on.provider import AUDIENCE, CLIENT, ISSUER, Endless, FakeProvider, rsa_key, sign
from tests.support.history import HistoryInMemory, open_at
from tests.support.waiting import until

REDIRECT = "https://robots.example/session/oidc/callback"
HOME = "192.0.2.7"
DISCOVERY = "/.well-known/openid-configuration"
SETTINGS: dict[str, Any] = {
    "oidc_issuer": ISSUER,
    "oidc_client_id": CLIENT,
    "oidc_audience": AUDIENCE,
    "oidc_roles": ("ops=operator", "admins=admin"),
}

pytestmark = pytest.mark.usefixtures("quick_hashes", "stopped_clock")


def make_logins(history: History, sso: SingleSignOn | None = None) -> Logins:
    """The logins of a gateway, with those of a provider."""
    logins = Logins(history)
    logins.sources.append(ProviderLogins(history, logins.guard, sso))
    return logins


def provider_of(logins: Logins) -> ProviderLogins:
    (found,) = logins.sources
    assert isinstance(found, ProviderLogins)
    return found


class Site:
    """Gateways that share their history and the provider. Time passes only where a test says so."""

    def __init__(self, fake: FakeProvider) -> None:
        self.fake = fake
        self.history: History = HistoryInMemory()
        self.now = 1_000_000.0
        self.timeout = 30.0

    @asynccontextmanager
    async def gateway(self, **settings: Any) -> AsyncIterator[Logins]:
        configured = SingleSignOnSettings(**{**SETTINGS, **settings})
        provider = Provider(configured, lambda: self.now, timeout=self.timeout)
        sso = SingleSignOn(configured, provider, lambda: self.now)
        logins = make_logins(self.history, sso)
        yield logins
        await provider_of(logins).close()
        await logins.close()


@pytest.fixture
def fake() -> FakeProvider:
    return FakeProvider()


@pytest.fixture
def site(fake: FakeProvider, monkeypatch: pytest.MonkeyPatch) -> Site:
    monkeypatch.setattr(provider_module, "_client", fake.client)
    return Site(fake)


@pytest.fixture
async def logins(site: Site) -> AsyncIterator[Logins]:
    async with site.gateway() as logins:
        yield logins


async def begin(logins: Logins, page: str = "/") -> tuple[str, LoginAttempt]:
    return await provider_of(logins).begin(page, REDIRECT)


async def finish(logins: Logins, attempt: LoginAttempt | None, said: dict[str, str]) -> str:
    """The secret of the session."""
    return (await provider_of(logins).log_in(attempt, said, REDIRECT, HOME))[1]


async def log_in(logins: Logins, fake: FakeProvider) -> str:
    address, attempt = await begin(logins)
    return await finish(logins, attempt, fake.authorize(address))


async def refused(logins: Logins, attempt: LoginAttempt | None, said: dict[str, str]) -> str:
    with pytest.raises(GatewayError) as error:
        await finish(logins, attempt, said)
    assert not provider_of(logins).people.count()
    return error.value.code


# ---------------------------------------------------------------------- people


async def test_a_person_logs_in(logins: Logins, fake: FakeProvider) -> None:
    address, attempt = await begin(logins)
    asked = {name: values[0] for name, values in parse_qs(urlsplit(address).query).items()}
    assert address.startswith(f"{ISSUER}/authorize?")
    assert (asked["response_type"], asked["code_challenge_method"]) == ("code", "S256")
    assert (asked["client_id"], asked["redirect_uri"], asked["scope"]) == (CLIENT, REDIRECT, "openid profile")
    assert len({asked["state"], asked["nonce"], asked["code_challenge"], attempt.verifier, attempt.secret}) == 5
    assert attempt.secret not in address
    assert attempt.verifier not in address

    principal, secret = await provider_of(logins).log_in(attempt, fake.authorize(address), REDIRECT, HOME)
    assert principal == logins.identify(secret)
    assert (principal.name, principal.kind, principal.grant) == ("oidc:ada", PrincipalKind.PERSON, Grant(Role.OPERATOR))
    (person,) = await provider_of(logins).people.documents()
    assert (person["name"], person["subject"], person["sessions"]) == ("oidc:ada", "4711", 1)
    (stored,) = (await provider_of(logins).people.book.read()).values()
    assert secret not in repr(stored)
    assert attempt.state not in repr(stored)


async def test_a_local_user_of_the_same_name_is_someone_else(logins: Logins, fake: FakeProvider) -> None:
    await logins.accounts.add("ada", Grant(Role.ADMIN), "correct horse battery staple")
    local = (await logins.log_in("ada", "correct horse battery staple", HOME))[0]
    person = logins.identify(await log_in(logins, fake))
    assert (local.name, person.name) == ("ada", "oidc:ada")
    await logins.log_out_person("oidc:ada")
    assert logins.is_valid(local)
    assert not logins.is_valid(person)
    with pytest.raises(GatewayError) as taken:
        await logins.create_token("OIDC:ada", Grant(Role.VIEWER))
    assert taken.value.code == "user_exists"


async def test_every_login_is_a_session_of_its_own_and_old_ones_make_room(logins: Logins, fake: FakeProvider) -> None:
    secrets = [await log_in(logins, fake) for _ in range(MAX_PER_USER + 2)]
    assert len(set(secrets)) == len(secrets)
    assert provider_of(logins).people.count() == {"oidc:ada": MAX_PER_USER}
    assert logins.identify(secrets[-1]).name == "oidc:ada"


async def test_a_state_is_used_once(site: Site, logins: Logins, fake: FakeProvider) -> None:
    address, attempt = await begin(logins)
    said = fake.authorize(address)
    secret = await finish(logins, attempt, said)
    await logins.log_out(secret)
    assert await refused(logins, attempt, said) == "login_failed"
    assert await refused(logins, attempt, fake.authorize(address)) == "login_failed"


async def test_a_state_is_used_once_at_all_gateways(site: Site, logins: Logins, fake: FakeProvider) -> None:
    address, attempt = await begin(logins)
    async with site.gateway() as other:
        secret = await finish(other, attempt, fake.authorize(address))
        await logins.refresh()
        assert logins.identify(secret).name == "oidc:ada"
        with pytest.raises(NotAuthenticated, match="used already"):
            await finish(logins, attempt, fake.authorize(address))
        assert provider_of(other).people.count() == {"oidc:ada": 1}


async def test_only_the_browser_that_has_begun_it_finishes_it(logins: Logins, fake: FakeProvider) -> None:
    """Login CSRF: an attacker's code and state, in the victim's browser, and the other way round."""
    address, _ = await begin(logins)
    other_address, other = await begin(logins)
    said = fake.authorize(address)
    assert await refused(logins, None, said) == "login_failed"
    assert await refused(logins, other, said) == "login_failed"
    for state in ("", "x", said["state"][:-1], "\u00e9\ud800"):
        assert await refused(logins, other, {**said, "state": state}) == "login_failed"
    assert await refused(logins, other, {"code": said["code"]}) == "login_failed"
    assert fake.redeemed == []
    stolen = {"code": said["code"], "state": other.state}  # a code of another login: PKCE and the nonce
    assert await refused(logins, other, stolen) == "login_failed"
    assert len(fake.redeemed) == 1
    assert other_address


async def test_a_login_expires(site: Site, logins: Logins, fake: FakeProvider) -> None:
    for late, code in ((LIFETIME, "login_failed"), (-LIFETIME, "login_failed")):
        address, attempt = await begin(logins)
        site.now += late
        assert await refused(logins, attempt, fake.authorize(address)) == code
    address, attempt = await begin(logins)
    site.now += LIFETIME - 2
    assert await finish(logins, attempt, fake.authorize(address))
    later = replace(attempt, started=attempt.started + LIFETIME)  # a cookie that was changed has another state
    assert later.state != attempt.state


@pytest.mark.parametrize(
    "changes",
    [
        {"nonce": None},
        {"nonce": "x"},
        {"aud": "another"},
        {"aud": [AUDIENCE]},
        {"azp": "another"},
        {"iss": "https://evil.example"},
        {"exp": 1},
        {"exp": None},
        {"iat": 4_000_000_000},
        {"sub": None},
        {"sub": ""},
        {"sub": "x" * 256},
        {"preferred_username": "\n"},
    ],
)
async def test_id_tokens_that_are_refused(logins: Logins, fake: FakeProvider, changes: dict[str, Any]) -> None:
    address, attempt = await begin(logins)
    fake.id_token = changes
    assert await refused(logins, attempt, fake.authorize(address)) == "login_failed"


async def test_an_id_token_of_another_key(logins: Logins, fake: FakeProvider) -> None:
    address, attempt = await begin(logins)
    fake.key = rsa_key("first")
    assert await refused(logins, attempt, fake.authorize(address)) == "login_failed"


@pytest.mark.parametrize("roles", [None, [], ["unknown"]])
async def test_who_has_no_role_does_not_get_in(logins: Logins, fake: FakeProvider, roles: Any) -> None:
    noted: list[str] = []
    fake.claims["roles"] = roles
    address, attempt = await begin(logins)
    with pytest.raises(GatewayError) as error:
        await provider_of(logins).log_in(attempt, fake.authorize(address), REDIRECT, HOME, noted.append)
    assert (error.value.code, noted) == ("role_required", ["oidc:ada (4711)"])
    assert not provider_of(logins).people.count()


async def test_roles_may_be_at_userinfo(logins: Logins, fake: FakeProvider) -> None:
    fake.claims["roles"] = None
    fake.document = {"userinfo_endpoint": f"{ISSUER}/userinfo"}
    fake.userinfo = {"sub": "4711", "roles": ["admins"], "preferred_username": "root", "nonce": "x"}
    assert logins.identify(await log_in(logins, fake)).grant == Grant(Role.ADMIN)
    await logins.log_out_person("oidc:ada")
    fake.userinfo["sub"] = "4712"
    address, attempt = await begin(logins)
    assert await refused(logins, attempt, fake.authorize(address)) == "login_failed"


async def test_what_the_provider_says_instead(logins: Logins) -> None:
    for said in ({"error": "access_denied"}, {"error": "<script>"}, {}, {"code": ""}, {"code": "x" * 5000}):
        _, attempt = await begin(logins)
        assert await refused(logins, attempt, {**said, "state": attempt.state}) == "login_failed"


async def test_another_provider_answers(logins: Logins, fake: FakeProvider) -> None:
    address, attempt = await begin(logins)
    said = {**fake.authorize(address), "iss": "https://evil.example"}
    assert await refused(logins, attempt, said) == "login_failed"
    assert fake.redeemed == []


async def test_a_role_changes_with_the_next_login(logins: Logins, fake: FakeProvider) -> None:
    first = await log_in(logins, fake)
    fake.claims["roles"] = ["admins"]
    second = await log_in(logins, fake)
    assert logins.identify(first).grant.role is Role.OPERATOR
    assert logins.identify(second).grant.role is Role.ADMIN


async def test_what_ends_a_session(site: Site, logins: Logins, fake: FakeProvider) -> None:
    async with site.gateway() as elsewhere:
        for end in ("log out", "admin", "expiry"):
            secret = await log_in(logins, fake)
            await elsewhere.refresh()
            ends: list[str] = []
            with elsewhere.watch(elsewhere.identify(secret), lambda: ends.append("ended")):  # noqa: B023
                match end:
                    case "log out":
                        await logins.log_out(secret)
                    case "admin":
                        await logins.log_out_person("oidc:ada")
                    case _:
                        key = digest_of(secret)[:ID_DIGITS]
                        session = (await provider_of(logins).people.book.read())[key]
                        hours = session.expires_at - session.created_at
                        assert hours == timedelta(hours=12)
                        await provider_of(logins).people.book.amend(
                            key, replace(session, expires_at=session.created_at)
                        )
                await elsewhere.refresh()
            assert ends == ["ended"]
            for each in (logins, elsewhere):
                with pytest.raises(NotAuthenticated):
                    each.identify(secret)
    with pytest.raises(NotFound):
        await logins.log_out_person("oidc:nobody")


async def test_sessions_of_another_provider_are_not_valid(site: Site, logins: Logins, fake: FakeProvider) -> None:
    secret = await log_in(logins, fake)
    async with site.gateway(oidc_issuer="https://other.example") as other:
        await other.refresh()
        with pytest.raises(NotAuthenticated):
            other.identify(secret)
    without = make_logins(site.history)
    await without.refresh()
    with pytest.raises(NotAuthenticated):
        without.identify(secret)
    assert logins.identify(secret)


async def test_two_gateways_on_one_database(site: Site, fake: FakeProvider, database_url: str, tmp_path: Path) -> None:
    fake.claims |= {"halls": ["/hall_a/*"]}
    async with open_at(database_url, tmp_path / "a") as one, open_at(database_url, tmp_path / "b") as other:
        await until(lambda: one.stats().database_reachable and other.stats().database_reachable)
        site.history = one
        async with site.gateway(oidc_robots_claim="halls") as here:
            site.history = other
            async with site.gateway() as elsewhere:
                secret = await log_in(here, fake)
                await elsewhere.refresh()
                assert elsewhere.identify(secret) == here.identify(secret)
                assert elsewhere.identify(secret).grant == Grant(Role.OPERATOR, ("/hall_a/*",))
                await elsewhere.refresh()  # stores the use
                await elsewhere.log_out_person("oidc:ada")
                await here.refresh()
                with pytest.raises(NotAuthenticated):
                    here.identify(secret)


async def test_failures_of_any_page_do_not_delay_logins(logins: Logins, fake: FakeProvider) -> None:
    for _ in range(50):
        assert await refused(logins, None, {"code": "x", "state": "y"}) == "login_failed"
    assert await log_in(logins, fake)


async def test_codes_that_are_guessed_are_delayed(logins: Logins) -> None:
    codes = []
    for _ in range(6):
        _, attempt = await begin(logins)
        codes.append(await refused(logins, attempt, {"code": "guess", "state": attempt.state}))
    assert codes == ["login_failed"] * 5 + ["too_many_logins"]


async def test_a_secret_is_sent_as_the_provider_wants_it(site: Site, fake: FakeProvider) -> None:
    async with site.gateway(oidc_client_secret="s3cret&") as logins:
        await log_in(logins, fake)
        assert "client_secret" not in fake.redeemed[-1]
        fake.document = {"token_endpoint_auth_methods_supported": ["client_secret_post"]}
        site.now += RECENT
        await log_in(logins, fake)
        assert fake.redeemed[-1]["client_secret"] == "s3cret&"


# ---------------------------------------------------------------------- the attempt


@pytest.mark.parametrize(
    ("page", "allowed"),
    [
        ("/", True),
        ("/ui/", True),
        ("/ui/goals?status=failed&robot=%2Frobot1", True),
        ("/sites/berlin/", True),
        ("/sites/berlin/ui/goals", True),
        ("/sites/berlin/goals", False),
        ("/sites//ui/", False),
        ("", False),
        ("//evil.example", False),
        ("/\\evil.example", False),
        ("/ui/\\evil.example", False),
        ("https://evil.example", False),
        ("/ui", False),
        ("/uix", False),
        ("/goals", False),
        ("ui/goals", False),
        ("/ui/\r\nSet-Cookie:x", False),
        ("/ui/goals\n", False),
        ("javascript:alert(1)", False),
        ("/ui/" + "a" * 500, False),
    ],
)
def test_pages_to_return_to(page: str, allowed: bool) -> None:
    assert is_page(page) is allowed
    kept = LoginAttempt.begin(page, 1.0).cookie if allowed or page.isascii() else ""
    assert (LoginAttempt.read(kept) is not None) is allowed


@pytest.mark.parametrize("cookie", [None, "", "x", "1.x.y", f"1.{'a' * 43}.!", f"1.{'a' * 42}.Lw", f"-1.{'a' * 43}.Lw"])
def test_cookies_that_are_none(cookie: str | None) -> None:
    assert LoginAttempt.read(cookie) is None


def test_a_cookie_is_read_as_it_was_written() -> None:
    attempt = LoginAttempt.begin("/ui/goals?a=b", 12.5)
    assert LoginAttempt.read(attempt.cookie) == attempt
    assert LoginAttempt.begin("/", 1.0).state != LoginAttempt.begin("/", 1.0).state


# ---------------------------------------------------------------------- services


async def identify(logins: Logins, token: str) -> Any:
    await logins.prepare(token)
    return logins.identify(token)


async def refusal(logins: Logins, token: str) -> str:
    with pytest.raises(GatewayError) as error:
        await identify(logins, token)
    return error.value.code


async def test_a_service_shows_an_access_token(logins: Logins, fake: FakeProvider) -> None:
    token = fake.access_token(preferred_username=None, sub="fleet-manager")
    principal = await identify(logins, token)
    assert (principal.name, principal.kind) == ("oidc:fleet-manager", PrincipalKind.SERVICE)
    assert principal.grant == Grant(Role.OPERATOR)
    assert logins.is_valid(principal)
    assert fake.asked == [DISCOVERY, "/keys"]
    await identify(logins, fake.access_token())
    assert fake.asked == [DISCOVERY, "/keys"]


async def test_access_tokens_that_are_refused(logins: Logins, fake: FakeProvider) -> None:
    await identify(logins, fake.access_token())
    for changes in (
        {"aud": CLIENT},
        {"aud": None},
        {"iss": "https://evil.example"},
        {"exp": 1},
        {"exp": None},
        {"nbf": 4_000_000_000},
        {"sub": None, "preferred_username": None},
    ):
        assert await refusal(logins, fake.access_token(**changes)) == "invalid_token"
    assert await refusal(logins, fake.access_token(roles=None)) == "role_required"
    assert (
        await refusal(logins, sign(rsa_key("first"), {"iss": ISSUER, "aud": AUDIENCE, "exp": 9e9})) == "invalid_token"
    )
    assert fake.asked == [DISCOVERY, "/keys"]


@pytest.mark.parametrize(
    ("kind", "claims"),
    [
        ("JWT", {"typ": "ID", "aud": [CLIENT, AUDIENCE]}),
        ("JWT", {"at_hash": "x", "aud": [CLIENT, AUDIENCE]}),
        ("JWT", {"c_hash": "x"}),
        ("JWT", {"typ": "Refresh"}),
        ("JWT", {"events": {"http://schemas.openid.net/event/backchannel-logout": {}}}),
        ("logout+jwt", {}),
        ("application/secevent+jwt", {}),
        ("DPoP+jwt", {}),
    ],
)
async def test_what_is_signed_for_another_purpose(
    logins: Logins, fake: FakeProvider, kind: str, claims: dict[str, Any]
) -> None:
    """The same provider, the same key, and the audience among others."""
    assert await refusal(logins, fake.access_token(kind, **claims)) == "invalid_token"


@pytest.mark.parametrize("kind", ["at+jwt", "application/at+JWT", "JWT", "jwt", None])
async def test_kinds_of_access_tokens(logins: Logins, fake: FakeProvider, kind: str | None) -> None:
    audiences = ["account", AUDIENCE]
    principal = await identify(logins, fake.access_token(kind, aud=audiences, typ="Bearer", nonce="x"))
    assert principal.name == "oidc:ada"


async def test_without_an_audience_there_are_no_services(site: Site, fake: FakeProvider) -> None:
    async with site.gateway(oidc_audience=None) as logins:
        assert await refusal(logins, fake.access_token()) == "invalid_token"
        assert await refusal(logins, fake.access_token(aud=CLIENT)) == "invalid_token"
        assert fake.asked == []
    async with site.gateway(oidc_client_id=None) as logins:
        assert (await identify(logins, fake.access_token())).name == "oidc:ada"
        with pytest.raises(NotFound):
            await begin(logins)
        with pytest.raises(NotFound):
            await finish(logins, None, {})
    assert await refusal(make_logins(site.history), fake.access_token()) == "invalid_token"


async def test_keys_are_rotated(site: Site, logins: Logins, fake: FakeProvider) -> None:
    old = await identify(logins, fake.access_token())
    first, fake.key = fake.key, rsa_key("second")
    fake.published.append(fake.key.as_dict(private=False))
    token = fake.access_token()
    assert await refusal(logins, token) == "invalid_token"  # it was asked a moment ago
    assert len(fake.asked) == 2
    site.now += RECENT
    new = await identify(logins, token)
    assert len(fake.asked) == 4
    assert logins.is_valid(old)
    fake.published = fake.published[1:]  # the first key is no longer trusted
    site.now += RECENT
    assert provider_of(logins).sso is not None
    await provider_of(logins).sso.provider.refresh()
    assert (logins.is_valid(old), logins.is_valid(new)) == (False, True)
    fake.key = first
    assert await refusal(logins, fake.access_token()) == "invalid_token"


async def test_unknown_keys_do_not_make_the_gateway_flood_the_provider(
    site: Site, logins: Logins, fake: FakeProvider
) -> None:
    await identify(logins, fake.access_token())
    site.now += RECENT
    claims = {"iss": ISSUER, "aud": AUDIENCE, "exp": 9_999_999_999, "sub": "x"}
    unknown = [sign(fake.key, claims, kid=f"unknown-{number}") for number in range(50)]
    codes = await asyncio.gather(*(refusal(logins, token) for token in unknown))
    assert set(codes) == {"invalid_token"}
    assert len(fake.asked) == 4


async def test_a_stream_ends_when_its_token_expires(
    logins: Logins, fake: FakeProvider, monkeypatch: pytest.MonkeyPatch
) -> None:
    from dock_gateway.extensions.single_sign_on import single_sign_on

    principal = await identify(logins, fake.access_token())
    ends: list[str] = []
    with logins.watch(principal, lambda: ends.append("ended")):
        await logins.refresh()
        assert ends == []
        monkeypatch.setattr(single_sign_on, "utc_now", lambda: principal.expires_at)
        await logins.refresh()
        assert set(ends) == {"ended"}
    with pytest.raises(NotAuthenticated):
        logins.require_valid(principal)
    assert BEHIND < 3.0


# ---------------------------------------------------------------------- a provider that is away, or worse


async def test_a_provider_that_is_down_keeps_nobody_out_who_is_in(
    site: Site, logins: Logins, fake: FakeProvider
) -> None:
    secret, token = await log_in(logins, fake), fake.access_token()
    service = await identify(logins, token)
    address, attempt = await begin(logins)
    fake.away = True
    site.now += RECENT
    with pytest.raises(Unavailable) as away:
        await begin(logins)
    assert (away.value.code, away.value.status) == ("provider_unavailable", 503)
    with pytest.raises(Unavailable):
        await finish(logins, attempt, fake.authorize(address))
    assert logins.identify(secret).name == "oidc:ada"
    assert await identify(logins, token) == service
    assert await refusal(logins, sign(rsa_key("x"), {"iss": ISSUER, "aud": AUDIENCE, "exp": 9e9})) == "invalid_token"
    async with site.gateway() as restarted:
        await restarted.refresh()
        assert restarted.identify(secret).name == "oidc:ada"
        assert await refusal(restarted, token) == "provider_unavailable"
        fake.away = False
        site.now += PAUSE
        assert await identify(restarted, token)


EVIL: dict[str, tuple[str, httpx2.Response]] = {
    "another issuer": (DISCOVERY, httpx2.Response(200, json={"issuer": "https://evil.example"})),
    "no JSON": (DISCOVERY, httpx2.Response(200, text="<html>")),
    "a list": (DISCOVERY, httpx2.Response(200, json=[])),
    "an error": (DISCOVERY, httpx2.Response(500, json={})),
    "a redirect": (DISCOVERY, httpx2.Response(302, headers={"Location": "http://169.254.169.254/"}, json={})),
    "no addresses": (DISCOVERY, httpx2.Response(200, json={"issuer": ISSUER})),
    "nested": (DISCOVERY, httpx2.Response(200, content=b"[" * 100_000)),
    "not UTF-8": (DISCOVERY, httpx2.Response(200, content=b'{"issuer": "\xff"}')),
    "endless keys": ("/keys", httpx2.Response(200, stream=Endless())),
    "slow keys": ("/keys", httpx2.Response(200, stream=Endless(b" ", 0.02))),
    "no keys": ("/keys", httpx2.Response(200, json={"keys": []})),
    "shared secrets": ("/keys", httpx2.Response(200, json={"keys": [{"kty": "oct", "k": "c2VjcmV0", "kid": "first"}]})),
    "packed": (
        DISCOVERY,
        httpx2.Response(200, headers={"Content-Encoding": "gzip"}, stream=httpx2.ByteStream(b"\x1f\x8b")),
    ),
}


@pytest.mark.parametrize("evil", EVIL)
async def test_answers_that_cannot_be_used(site: Site, fake: FakeProvider, evil: str) -> None:
    site.timeout = 0.3 if evil == "slow keys" else 30.0
    async with site.gateway() as logins:
        token = fake.access_token()
        service = await identify(logins, token)
        path, answer = EVIL[evil]
        fake.answers[path] = answer
        site.now += RECENT
        with pytest.raises(Unavailable) as refused:
            await begin(logins)
        assert refused.value.code == "provider_unavailable"
        assert await identify(logins, token) == service  # with the keys of before


@pytest.mark.parametrize("name", ["authorization_endpoint", "token_endpoint", "jwks_uri", "end_session_endpoint"])
@pytest.mark.parametrize(
    "address", ["http://evil.example/", "file:///etc/passwd", "//x", "javascript:x", "https://a@b/", 7]
)
async def test_addresses_that_are_not_safe(logins: Logins, fake: FakeProvider, name: str, address: Any) -> None:
    fake.document = {name: address}
    with pytest.raises(Unavailable):
        await begin(logins)


@pytest.mark.parametrize(
    ("answer", "code"),
    [
        (httpx2.Response(400, json={"error": "invalid_grant"}), "login_failed"),
        (httpx2.Response(401, json={"error": "invalid_client"}), "provider_unavailable"),
        (httpx2.Response(503, text="busy"), "provider_unavailable"),
        (httpx2.Response(302, headers={"Location": "https://evil.example/"}, json={}), "login_failed"),
        (httpx2.Response(200, json={}), "login_failed"),
        (httpx2.Response(200, json={"id_token": 7}), "login_failed"),
        (httpx2.Response(200, json={"id_token": "x" * 100_000}), "login_failed"),
        (httpx2.Response(200, json={"id_token": "a.b.c"}), "login_failed"),
        (httpx2.Response(200, stream=Endless()), "provider_unavailable"),
    ],
)
async def test_answers_about_a_code(logins: Logins, fake: FakeProvider, answer: httpx2.Response, code: str) -> None:
    address, attempt = await begin(logins)
    fake.answers["/token"] = answer
    assert await refused(logins, attempt, fake.authorize(address)) == code


async def test_logging_out_at_the_provider(site: Site, logins: Logins, fake: FakeProvider) -> None:
    assert provider_of(logins).sso is not None
    assert (provider_of(logins).sso.name, provider_of(logins).sso.logout_url) == ("login.example", None)
    fake.document = {"end_session_endpoint": f"{ISSUER}/logout"}
    await begin(logins)
    assert provider_of(logins).sso.logout_url == f"{ISSUER}/logout?client_id={CLIENT}"


async def test_the_gateway_does_not_wait_for_the_provider(site: Site, fake: FakeProvider) -> None:
    fake.away = True
    async with site.gateway() as logins:
        await asyncio.wait_for(logins.open(), 5)

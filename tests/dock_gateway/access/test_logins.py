"""Users and their sessions: who is let in, for how long, and what ends their streams."""

import asyncio
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import cast
from unittest.mock import Mock

import pytest
from cryptography.hazmat.primitives.kdf.argon2 import Argon2id

from dock_gateway.access import passwords
from dock_gateway.access.credentials import ID_DIGITS, digest_of
from dock_gateway.access.logins import Logins
from dock_gateway.access.passwords import Passwords
from dock_gateway.access.sessions import LIFETIME, MAX_PER_USER
from dock_gateway.core.access import IDLE, Principal, PrincipalKind, Session, Token, User
from dock_gateway.core.errors import Conflict, NotAllowed, NotAuthenticated, NotFound, TooManyRequests, Unavailable
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.request import PERMIT
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from tests.support.entries import SharedStore
from tests.support.history import open_at
from tests.support.permits import permit, user
from tests.support.waiting import until

ADMIN, OPERATOR, VIEWER = Grant(Role.ADMIN), Grant(Role.OPERATOR), Grant(Role.VIEWER)
PASSWORD, OTHER = "correct horse battery staple", "another horse, another battery"
HOME = "192.0.2.7"

pytestmark = pytest.mark.usefixtures("quick_hashes", "stopped_clock")


class Site:
    """Gateways that share their history."""

    def __init__(self) -> None:
        self.users: SharedStore[User] = SharedStore()
        self.sessions: SharedStore[Session] = SharedStore()
        self.tokens: SharedStore[Token] = SharedStore()

    def logins(self, **timing: float) -> Logins:
        stores = {"user": self.users, "session": self.sessions, "token": self.tokens}
        history = SimpleNamespace(documents=lambda kind, _: stores[kind])
        return Logins(cast("History", history), **timing)

    def go_away(self) -> None:
        self.users.away = self.sessions.away = self.tokens.away = True

    async def age(self, secret: str, *, created: timedelta = timedelta(0), used: timedelta = timedelta(0)) -> None:
        """Let a session have been created and used earlier."""
        key = digest_of(secret)[:ID_DIGITS]
        session = (await self.sessions.read())[key]
        older = replace(
            session,
            created_at=session.created_at - created,
            expires_at=session.expires_at - created,
            used_at=session.used_at - used,
        )
        await self.sessions.write(key, older)


@pytest.fixture
def site() -> Site:
    return Site()


@pytest.fixture
async def logins(site: Site) -> Logins:
    """A gateway with an admin and an operator."""
    logins = site.logins()
    await logins.accounts.add("root", ADMIN, PASSWORD)
    await logins.accounts.add("ada", OPERATOR, PASSWORD, by="root")
    return logins


async def log_in(logins: Logins, name: str = "ada", password: str = PASSWORD, address: str = HOME) -> str:
    return (await logins.log_in(name, password, address))[1]


def is_in(logins: Logins, secret: str) -> bool:
    try:
        logins.identify(secret)
    except NotAuthenticated:
        return False
    return True


@contextmanager
def watching(logins: Logins, secret: str) -> Iterator[list[str]]:
    """The ends of a stream of who shows this secret."""
    ends: list[str] = []
    with logins.watch(logins.identify(secret), lambda: ends.append("ended")):
        yield ends


async def test_a_session_says_who_shows_it(site: Site, logins: Logins) -> None:
    principal, secret = await logins.log_in("ada", PASSWORD, HOME)
    assert principal == logins.identify(secret)
    assert principal == Principal("ada", PrincipalKind.USER, OPERATOR, digest_of(secret)[:ID_DIGITS])
    assert secret.startswith("dgs_")
    stored = repr((await site.users.read(), await site.sessions.read()))
    assert secret not in stored
    assert PASSWORD not in stored
    (root, ada) = sorted(await logins.accounts.documents(), key=lambda user: user["role"])
    assert (ada["name"], ada["created_by"], ada["sessions"], ada["disabled"]) == ("ada", "root", 1, False)
    assert ada["logged_in_at"] is not None
    assert (root["logged_in_at"], root["sessions"]) == (None, 0)
    assert {"password", "era"}.isdisjoint(ada)


async def test_every_login_is_a_session_of_its_own(logins: Logins) -> None:
    first, second = await log_in(logins), await log_in(logins)
    assert first != second
    await logins.log_out(first)
    assert (is_in(logins, first), is_in(logins, second)) == (False, True)


@pytest.mark.parametrize(
    ("name", "password"),
    [("ada", OTHER), ("ada", ""), ("nobody", PASSWORD), ("", ""), ("ada", PASSWORD + " "), ("ada", "\ud800" * 200)],
)
async def test_a_wrong_name_or_password_is_refused_alike(logins: Logins, name: str, password: str) -> None:
    with pytest.raises(NotAuthenticated) as refused:
        await log_in(logins, name, password)
    assert refused.value.code == "invalid_login"
    assert refused.value.detail == "the name or the password is wrong, or the user is disabled"


async def test_an_unknown_user_takes_as_long(logins: Logins, monkeypatch: pytest.MonkeyPatch) -> None:
    verified: list[str] = []
    verify = Argon2id.verify_phc_encoded

    def count(password: bytes, hashed: str) -> None:
        verified.append(hashed)
        verify(password, hashed)

    monkeypatch.setattr(passwords, "Argon2id", Mock(wraps=Argon2id, verify_phc_encoded=count))
    for name in ("ada", "nobody"):
        with pytest.raises(NotAuthenticated):
            await log_in(logins, name, OTHER)
    assert len(verified) == 2
    assert {hashed.rpartition("$")[0].rpartition("$")[0] for hashed in verified} == {"$argon2id$v=19$m=8,t=1,p=1"}


async def test_letters_count_however_the_keyboard_sends_them(logins: Logins) -> None:
    await logins.accounts.add("jose", VIEWER, "contrase\u00f1a secreta")
    assert is_in(logins, await log_in(logins, "jose", "contrasen\u0303a secreta"))


@pytest.mark.parametrize("stored", ["", "plain", "$argon2id$v=19$m=8,t=1,p=1$x$y"])
async def test_what_is_stored_instead_of_a_hash_lets_nobody_in(site: Site, logins: Logins, stored: str) -> None:
    await site.users.write("ada", replace((await site.users.read())["ada"], password=stored))
    with pytest.raises(NotAuthenticated):
        await log_in(logins, password=stored or PASSWORD)


async def test_an_outdated_hash_is_renewed(site: Site, logins: Logins) -> None:
    old = Argon2id(salt=b"salt" * 4, length=32, iterations=2, lanes=1, memory_cost=16).derive_phc_encoded(
        PASSWORD.encode()
    )
    await site.users.write("ada", replace((await site.users.read())["ada"], password=old))
    assert is_in(logins, await log_in(logins))
    assert "m=8,t=1" in (await site.users.read())["ada"].password
    assert is_in(logins, await log_in(logins))


@pytest.mark.parametrize(
    ("created", "used", "valid"),
    [
        (timedelta(0), timedelta(0), True),
        (LIFETIME - timedelta(minutes=1), timedelta(0), True),
        (LIFETIME, timedelta(0), False),
        (IDLE, IDLE - timedelta(minutes=1), True),
        (IDLE, IDLE, False),
    ],
)
async def test_a_session_expires(site: Site, logins: Logins, created: timedelta, used: timedelta, valid: bool) -> None:
    secret = await log_in(logins)
    with watching(logins, secret) as ends:
        await site.age(secret, created=created, used=used)
        await logins.refresh()
        assert is_in(logins, secret) is valid
        assert bool(ends) is not valid
    await logins.refresh()
    assert len(await site.sessions.read()) == valid


async def test_its_use_keeps_it(site: Site, logins: Logins) -> None:
    secret = await log_in(logins)
    await site.age(secret, used=timedelta(days=6))
    await logins.refresh()
    logins.identify(secret)
    await logins.refresh()
    (stored,) = (await site.sessions.read()).values()
    assert stored.used_at > stored.created_at


ENDINGS = {
    "logged out everywhere": lambda logins: logins.accounts.end_sessions("ada"),
    "disabled": lambda logins: logins.accounts.edit("ada", disabled=True),
    "removed": lambda logins: logins.accounts.remove("ada"),
    "new password": lambda logins: logins.accounts.edit("ada", password=OTHER),
}


@pytest.mark.parametrize("ending", ENDINGS)
async def test_what_ends_all_sessions_of_a_user(site: Site, logins: Logins, ending: str) -> None:
    elsewhere = site.logins()
    secret, root = await log_in(logins), await log_in(logins, "root")
    await elsewhere.refresh()
    with watching(logins, secret) as ends, watching(elsewhere, secret) as later, watching(logins, root) as others:
        await ENDINGS[ending](logins)
        assert (ends, later) == (["ended"], [])
        assert not is_in(logins, secret)
        await elsewhere.refresh()
        assert later == ["ended"]
        assert not is_in(elsewhere, secret)
        assert others == []
        assert is_in(elsewhere, root)


async def test_who_is_enabled_or_added_again_has_to_log_in_again(logins: Logins) -> None:
    secret = await log_in(logins)
    await logins.accounts.edit("ada", disabled=True)
    with pytest.raises(NotAuthenticated, match="disabled"):
        await log_in(logins)
    await logins.accounts.edit("ada", disabled=False)
    assert not is_in(logins, secret)
    secret = await log_in(logins)
    await logins.accounts.remove("ada")
    await logins.accounts.add("ada", ADMIN, PASSWORD)
    assert not is_in(logins, secret)


async def test_a_changed_role_holds_at_once_and_ends_streams(site: Site, logins: Logins) -> None:
    elsewhere = site.logins()
    secret = await log_in(logins)
    await elsewhere.refresh()
    before = logins.identify(secret)
    with watching(logins, secret) as ends, watching(elsewhere, secret) as later:
        await logins.accounts.edit("ada", VIEWER)
        assert ends == ["ended"]
        assert logins.identify(secret).grant == VIEWER
        assert not logins.is_valid(before)
        assert elsewhere.is_valid(before)
        await elsewhere.refresh()
        assert later == ["ended"]
        assert elsewhere.identify(secret).grant == VIEWER


async def test_a_user_changes_the_own_password(logins: Logins) -> None:
    first, second = await log_in(logins), await log_in(logins)
    with pytest.raises(NotAllowed) as wrong:
        await logins.change_password("ada", OTHER, OTHER, HOME)
    assert wrong.value.code == "wrong_password"
    assert is_in(logins, first)
    new = await logins.change_password("ada", PASSWORD, OTHER, HOME)
    assert [is_in(logins, secret) for secret in (first, second, new)] == [False, False, True]
    with pytest.raises(NotAuthenticated):
        await log_in(logins)
    assert is_in(logins, await log_in(logins, password=OTHER))


async def test_the_old_password_cannot_be_guessed_with_a_stolen_session(logins: Logins) -> None:
    for _ in range(5):
        with pytest.raises(NotAllowed):
            await logins.change_password("ada", OTHER, OTHER, HOME)
    with pytest.raises(TooManyRequests) as limited:
        await logins.change_password("ada", PASSWORD, OTHER, HOME)
    assert limited.value.code == "too_many_logins"


async def test_guessing_is_delayed_and_says_for_how_long(logins: Logins) -> None:
    assert is_in(logins, await log_in(logins))  # the user's usual place
    for _ in range(5):
        with pytest.raises(NotAuthenticated):
            await log_in(logins, password=OTHER, address="198.51.100.1")
    with pytest.raises(TooManyRequests) as limited:
        await log_in(logins, address="198.51.100.1")
    assert (limited.value.code, limited.value.extra) == ("too_many_logins", {"retry_after": 1})
    assert is_in(logins, await log_in(logins))


async def test_in_a_known_browser_only_its_own_failures_count(logins: Logins) -> None:
    await log_in(logins)
    known = logins.guard.known_cookie("ada", None)
    refused = []
    for _ in range(110):
        with pytest.raises((NotAuthenticated, TooManyRequests)) as error:
            await logins.log_in("ada", OTHER, HOME)
        refused.append(error.value.code)
    assert refused == ["invalid_login"] * 101 + ["too_many_logins"] * 9
    for made_up in (None, "a" * 22, f"{'a' * 22}.{'b' * 22}", logins.guard.known_cookie("root", None)):
        with pytest.raises(TooManyRequests):
            await logins.log_in("ada", PASSWORD, HOME, made_up)
    assert is_in(logins, (await logins.log_in("ada", PASSWORD, HOME, known))[1])
    assert is_in(logins, (await logins.log_in("ada", PASSWORD, "203.0.113.5", known))[1])
    for _ in range(5):
        with pytest.raises(NotAuthenticated):
            await logins.log_in("ada", OTHER, HOME, known)
    with pytest.raises(TooManyRequests):
        await logins.log_in("ada", PASSWORD, HOME, known)


async def test_an_outage_is_no_failed_login(site: Site, logins: Logins) -> None:
    known = await log_in(logins)
    site.go_away()
    for _ in range(10):
        with pytest.raises(Unavailable):
            await log_in(logins)
    await logins.refresh()
    assert is_in(logins, known)
    site.users.away = site.sessions.away = site.tokens.away = False
    assert is_in(logins, await log_in(logins))


async def test_wrong_tokens_are_delayed_like_wrong_passwords_and_a_valid_one_is_not(logins: Logins) -> None:
    _, secret = await logins.create_token("cron", VIEWER)
    for _ in range(5):
        with pytest.raises(NotAuthenticated):
            logins.identify_token("dgw_wrong", HOME)
    with pytest.raises(TooManyRequests):
        logins.identify_token("dgw_wrong", HOME)
    assert logins.identify_token(secret, HOME).name == "cron"  # whoever has failed at the same address
    assert logins.identify(secret).name == "cron"  # requests with a token never wait


async def test_old_sessions_make_room(site: Site, logins: Logins) -> None:
    root = await log_in(logins, "root")
    secrets = []
    for number in range(MAX_PER_USER + 2):
        secrets.append(await log_in(logins))
        await site.age(secrets[-1], used=timedelta(hours=100 - number))
        await logins.refresh()
    assert [is_in(logins, secret) for secret in secrets] == [False] * 2 + [True] * MAX_PER_USER
    assert is_in(logins, root)


async def test_the_last_admin_stays(logins: Logins) -> None:
    for attempt in (
        lambda: logins.accounts.remove("root"),
        lambda: logins.accounts.edit("root", disabled=True),
        lambda: logins.accounts.edit("root", OPERATOR),
    ):
        with pytest.raises(Conflict) as kept:
            await attempt()
        assert kept.value.code == "last_admin"
    assert is_in(logins, await log_in(logins, "root"))
    await logins.accounts.edit("root", ADMIN, OTHER)
    await logins.create_token("emergency", ADMIN)
    await logins.accounts.remove("root")
    await logins.accounts.edit("ada", VIEWER)


async def test_two_admins_cannot_remove_each_other_at_the_same_time(site: Site, logins: Logins) -> None:
    await logins.accounts.add("eve", ADMIN, PASSWORD)
    done = await asyncio.gather(
        logins.accounts.edit("root", disabled=True), site.logins().accounts.remove("eve"), return_exceptions=True
    )
    assert [isinstance(each, Conflict) for each in done].count(True) == 1


async def test_names_are_used_once(logins: Logins) -> None:
    await logins.create_token("Cron", VIEWER)
    for name, code in (("ada", "user_exists"), ("cron", "token_exists")):
        with pytest.raises(Conflict) as taken:
            await logins.accounts.add(name, ADMIN, PASSWORD)
        assert taken.value.code == code
    with pytest.raises(Conflict) as user:
        await logins.create_token("Ada", VIEWER)
    assert user.value.code == "user_exists"


async def test_who_is_not_there(logins: Logins) -> None:
    for attempt in (logins.accounts.edit, logins.accounts.remove, logins.accounts.end_sessions):
        with pytest.raises(NotFound) as missing:
            await attempt("nobody")
        assert missing.value.code == "user_not_found"


async def test_a_login_overwrites_no_change_of_another_gateway(site: Site, logins: Logins) -> None:
    elsewhere = site.logins()
    await elsewhere.accounts.edit("ada", VIEWER)
    principal, _ = await logins.log_in("ada", PASSWORD, HOME)
    assert principal.grant == VIEWER
    assert (await site.users.read())["ada"].role is Role.VIEWER


async def test_a_password_that_changes_during_a_login_is_too_late_for_it(
    site: Site, logins: Logins, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = site.logins()
    verify = Passwords.verify

    async def overtaken(self: Passwords, password: str, hashed: str | None) -> tuple[bool, str | None]:
        verified = await verify(self, password, hashed)
        await elsewhere.accounts.edit("ada", password=OTHER)
        return verified

    monkeypatch.setattr(Passwords, "verify", overtaken)
    with pytest.raises(NotAuthenticated):
        await log_in(logins)
    assert await site.sessions.read() == {}


async def test_a_flood_of_logins_hashes_one_at_a_time(logins: Logins, monkeypatch: pytest.MonkeyPatch) -> None:
    running, most = 0, 0
    verify = Argon2id.verify_phc_encoded

    def count(password: bytes, hashed: str) -> None:
        nonlocal running, most
        running += 1
        most = max(most, running)
        time.sleep(0.001)
        running -= 1
        verify(password, hashed)

    monkeypatch.setattr(passwords, "Argon2id", Mock(wraps=Argon2id, verify_phc_encoded=count))
    quotas = Quotas(Settings())

    async def attempt(number: int) -> str:
        PERMIT.set(permit(quotas, user(None, Role.VIEWER, f"198.51.100.{number}")))
        return await log_in(logins, f"name{number}", address=f"198.51.100.{number}")

    refused = await asyncio.gather(*map(attempt, range(150)), return_exceptions=True)
    codes = [getattr(each, "code", None) for each in refused]
    assert most == 1
    assert codes.count("invalid_login") >= 90
    assert codes.count("too_many_logins") == 150 - codes.count("invalid_login") > 0


async def test_streams_are_watched_while_the_gateway_runs(site: Site, logins: Logins) -> None:
    secret = await log_in(logins)
    elsewhere = site.logins(sync_interval=0.01)
    await elsewhere.open()
    ended = asyncio.Event()
    with elsewhere.watch(elsewhere.identify(secret), ended.set):
        await logins.log_out(secret)
        await asyncio.wait_for(ended.wait(), 10)
    await elsewhere.close()


async def test_a_gateway_that_nobody_can_log_in_at_says_so(site: Site, caplog: pytest.LogCaptureFixture) -> None:
    logins = site.logins(sync_interval=0.01)
    await logins.open()
    await until(lambda: "dock-gateway user create" in caplog.text)
    await logins.close()
    caplog.clear()
    await logins.accounts.add("ada", ADMIN, PASSWORD)
    await logins.open()
    await asyncio.sleep(0.1)
    await logins.close()
    assert caplog.text == ""


async def test_two_gateways_on_one_database(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path / "a") as one, open_at(database_url, tmp_path / "b") as other:
        await until(lambda: one.stats().database_reachable and other.stats().database_reachable)
        here, elsewhere = Logins(one), Logins(other)
        limited = Grant(Role.OPERATOR, ("/hall_a/*",), (), ("*/battery_status",))
        await here.accounts.add("root", ADMIN, PASSWORD)
        await here.accounts.add("ada", limited, PASSWORD, by="root", disabled=True)
        await elsewhere.accounts.edit("ada", disabled=False)
        principal, secret = await elsewhere.log_in("ada", PASSWORD, HOME)
        assert principal.grant == limited
        await here.refresh()
        assert here.identify(secret) == principal
        (stored, root) = await here.accounts.documents()
        assert (stored["created_by"], stored["sessions"], stored["disabled"]) == ("root", 1, False)
        edits = (here.accounts.edit("ada", Grant(role)) for role in Role)
        await asyncio.gather(elsewhere.log_in("ada", PASSWORD, HOME), *edits)
        await here.accounts.end_sessions("ada")
        await elsewhere.refresh()
        assert not is_in(elsewhere, secret)
        await here.accounts.remove("ada")
        assert await elsewhere.accounts.documents() == [root]

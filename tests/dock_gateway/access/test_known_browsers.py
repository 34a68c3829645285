"""The cookie of a browser in which a user has logged in: only a login makes one, and it is good for that user alone."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.access.known_browsers import MAX_USERS, browser_of, remember
from dock_gateway.access.users import new_user
from dock_gateway.core.access import User
from dock_gateway.core.grant import Grant, Role

ADA, BOB = (new_user(Grant(Role.OPERATOR), password, None, disabled=False) for password in ("hash a", "hash b"))


def test_a_browser_is_known_for_those_who_logged_in_there() -> None:
    cookie = remember(None, "ada", ADA)
    browser = browser_of(cookie, "ada", ADA)
    assert browser is not None
    assert browser_of(cookie, "bob", BOB) is None
    assert browser_of(cookie, "bob", ADA) is None
    assert browser_of(cookie, "ada", None) is None
    shared = remember(cookie, "bob", BOB)
    assert browser_of(shared, "ada", ADA) == browser_of(shared, "bob", BOB) == browser
    assert len(remember(shared, "ada", ADA)) == len(shared)  # once each
    other = browser_of(remember(None, "ada", ADA), "ada", ADA)
    assert other not in (None, browser)


@pytest.mark.parametrize("change", [{"password": "hash c"}, {"era": "another"}])
def test_a_new_password_or_the_end_of_all_sessions_ends_it(change: dict[str, str]) -> None:
    cookie = remember(None, "ada", ADA)
    assert browser_of(cookie, "ada", replace(ADA, **change)) is None  # type: ignore[arg-type]


@given(st.text(max_size=30), st.text(alphabet="ab._-", max_size=60))
def test_what_is_made_up_is_not_known_and_is_no_error(text: str, similar: str) -> None:
    for cookie in (text, similar, "a" * 22, f"{'a' * 22}.{'b' * 22}", f"{remember(None, 'ada', ADA)}.", "é" * 22):
        assert browser_of(cookie, "ada", BOB) is None
        assert browser_of(remember(cookie, "ada", ADA), "ada", ADA) is not None


def test_the_signature_is_of_that_browser() -> None:
    """Nobody can count their failures under an id of their own."""
    _, signature = remember(None, "ada", ADA).split(".")
    assert browser_of(f"{'a' * 22}.{signature}", "ada", ADA) is None


def test_a_browser_is_known_for_the_last_users_of_many() -> None:
    users: list[User] = [replace(ADA, password=f"hash {number}") for number in range(20)]
    cookie = None
    for number, user in enumerate(users):
        cookie = remember(cookie, f"user{number}", user)
    known = [browser_of(cookie, f"user{number}", user) is not None for number, user in enumerate(users)]
    assert known == [False] * (20 - MAX_USERS) + [True] * MAX_USERS
    long = ".".join([cookie or "", *["b" * 22] * 1000])
    assert browser_of(long, "user19", users[19]) is not None

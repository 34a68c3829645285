"""Delays after failed logins: how often one may try, and that nobody can be locked out of their usual place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.access.login_delays import ADDRESS, FORGET, MAX_REMEMBERED, NAME, PAIR, LoginDelays, network_of

HOUR = 3600.0


def fail(delays: LoginDelays, name: str, address: str, now: float, times: int = 1) -> float:
    """Fail several times, each as soon as possible; when the next attempt is possible."""
    for _ in range(times):
        while (wait := delays.attempt(name, address, now)) > 0:
            now += wait
    return now


def test_the_fifth_failure_and_those_after_it_delay_the_next_attempt() -> None:
    delays = LoginDelays()
    waits = []
    now = 0.0
    for _ in range(16):
        now = fail(delays, "ada", "a", now)
        waits.append(LoginDelays.attempt(delays, "ada", "a", now))
        if waits[-1] == 0.0:
            delays.withdraw("ada", "a")
    assert waits == [0, 0, 0, 0, 1, 2, 4, 8, 16, 32, 64, 128, 256, 300, 300, 300]


def test_attempts_at_the_same_time_are_no_way_around() -> None:
    delays = LoginDelays()
    allowed = [delays.attempt("ada", "a", 0.0) == 0.0 for _ in range(50)]
    assert allowed == [True] * 5 + [False] * 45


def test_a_success_forgets_the_failures_of_the_name_and_not_those_of_the_address() -> None:
    delays = LoginDelays()
    now = fail(delays, "ada", "a", 0.0, times=4)
    assert delays.attempt("ada", "a", now) == 0.0
    delays.succeed("ada", "a")
    assert [delays.attempt("ada", "a", now) for _ in range(5)] == [0.0] * 5
    assert delays.attempt("ada", "a", now) == 1.0
    # Someone with a login of their own cannot guess the passwords of others between their logins.
    delays = LoginDelays()
    for count in range(ADDRESS.free + 1):
        assert delays.attempt(f"name{count}", "a", now) == 0.0
        if delays.attempt("eve", "a", now) == 0.0:
            delays.succeed("eve", "a")
    assert delays.attempt("other", "a", now) > 0.0


def test_one_address_cannot_try_many_names_and_other_addresses_go_on() -> None:
    delays = LoginDelays()
    tried = sum(delays.attempt(f"name{count}", "a", 0.0) == 0.0 for count in range(1000))
    assert tried == ADDRESS.free + 1
    assert delays.attempt("ada", "b", 0.0) == 0.0


def test_many_addresses_cannot_try_one_name_often() -> None:
    delays = LoginDelays()
    tried = 0
    for second in range(int(HOUR)):
        tried += sum(delays.attempt("ada", f"{second}.{count}", float(second)) == 0.0 for count in range(20))
    assert tried <= NAME.free + 5 + HOUR / NAME.longest


def test_tokens_are_delayed_by_address_alone() -> None:
    delays = LoginDelays()
    for count in range(100):
        assert delays.attempt("", f"{count}", 0.0) == 0.0
    assert [delays.attempt("", "0", 0.0) > 0 for _ in range(5)] == [False] * 4 + [True]


def test_failures_are_forgotten_after_an_hour() -> None:
    delays = LoginDelays()
    now = fail(delays, "ada", "a", 0.0, times=12)
    assert delays.attempt("ada", "a", now) > 0
    assert fail(delays, "ada", "a", now + FORGET + 301, times=PAIR.free) == now + FORGET + 301


ATTEMPTS = st.lists(
    st.tuples(
        st.sampled_from(["ada", "bob", ""]),
        st.sampled_from(["a", "b", "c"]),
        st.floats(0, 400),
        st.sampled_from(["fail", "succeed", "withdraw"]),
    ),
    max_size=200,
)


@given(ATTEMPTS)
def test_the_name_s_usual_address_is_never_delayed_by_others(attempts: list[tuple[str, str, float, str]]) -> None:
    delays = LoginDelays()
    assert delays.attempt("ada", "home", 0.0) == 0.0
    delays.succeed("ada", "home")
    now = 0.0
    for name, address, later, outcome in attempts:
        now += later
        if delays.attempt(name, address, now) == 0.0 and outcome != "fail":
            getattr(delays, outcome)(name, address)
        assert delays.attempt("ada", "home", now) == 0.0
        delays.succeed("ada", "home")


@given(ATTEMPTS)
def test_who_waits_as_long_as_told_may_try(attempts: list[tuple[str, str, float, str]]) -> None:
    delays = LoginDelays()
    now = 0.0
    for name, address, later, outcome in attempts:
        now += later
        wait = delays.attempt(name, address, now)
        assert 0.0 <= wait <= PAIR.longest
        if wait > 0.0:
            now += wait + 1e-6
            assert delays.attempt(name, address, now) == 0.0
        if outcome != "fail":
            getattr(delays, outcome)(name, address)


@given(st.lists(st.floats(0, 60), max_size=300))
def test_one_address_has_few_tries_for_one_name(pauses: list[float]) -> None:
    """Whatever the rhythm: each failure after the fourth doubles the time to the next."""
    delays, now, tries = LoginDelays(), 0.0, 0
    for pause in pauses:
        now += pause
        tries += delays.attempt("ada", "a", now) == 0.0
    assert tries <= PAIR.free + 10 + now / PAIR.longest


def test_no_more_than_so_many_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dock_gateway.access.login_delays.MAX_REMEMBERED", 100)
    assert MAX_REMEMBERED > 100
    delays = LoginDelays()
    for count in range(1000):
        delays.attempt(f"name{count}", f"{count}", float(count))
        assert len(delays) <= 100
        delays.succeed(f"known{count}", f"{count}")
        assert len(delays) <= 100


@pytest.mark.parametrize(
    ("address", "network"),
    [
        ("192.0.2.7", "192.0.2.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::"),
        ("2001:db8:1:2::1", "2001:db8:1:2::"),
        ("::ffff:192.0.2.7", "192.0.2.7"),
        ("fe80::1%eth0", "fe80::"),
        ("testclient", "testclient"),
        ("", ""),
    ],
)
def test_an_address_counts_as_far_as_a_client_cannot_change_it(address: str, network: str) -> None:
    assert network_of(address) == network

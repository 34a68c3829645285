"""Delays after failed logins: how often one may try, and that nobody can be locked out of their usual place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.access.login_delays import (
    ADDRESS,
    FORGET,
    KNOWN,
    MAX_REMEMBERED,
    NAME,
    PAIR,
    TOKENS,
    LoginDelays,
    network_of,
)

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
    assert [delays.attempt("ada", "a", now) for _ in range(KNOWN.free + 1)] == [0.0] * (KNOWN.free + 1)
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
        assert delays.attempt(TOKENS, f"{count}", 0.0) == 0.0
    assert [delays.attempt(TOKENS, "0", 0.0) > 0 for _ in range(5)] == [False] * 4 + [True]


def test_failures_are_forgotten_after_an_hour() -> None:
    delays = LoginDelays()
    now = fail(delays, "ada", "a", 0.0, times=12)
    assert delays.attempt("ada", "a", now) > 0
    assert fail(delays, "ada", "a", now + FORGET + 301, times=PAIR.free) == now + FORGET + 301


ATTEMPTS = st.lists(
    st.tuples(
        st.sampled_from(["ada", "bob", TOKENS]),
        st.sampled_from(["a", "b", "home"]),
        st.floats(0, 400),
        st.sampled_from(["fail", "succeed", "withdraw"]),
    ),
    max_size=200,
)


@given(ATTEMPTS, st.sampled_from([None, "browser"]))
def test_a_name_is_never_delayed_at_its_usual_place_by_others(
    attempts: list[tuple[str, str, float, str]], browser: str | None
) -> None:
    """Whoever fails with whatever name at whatever address, also at that very one."""
    delays = LoginDelays()
    assert delays.attempt("ada", "home", 0.0, browser) == 0.0
    delays.succeed("ada", "home", browser)
    now = 0.0
    for name, address, later, outcome in attempts:
        now += later
        if delays.attempt(name, address, now) == 0.0 and (
            outcome == "withdraw" or (outcome, name) == ("succeed", "bob")
        ):
            getattr(delays, outcome)(name, address)
        assert delays.attempt("ada", "home", now, browser) == 0.0
        delays.succeed("ada", "home", browser)


@given(st.lists(st.tuples(st.sampled_from(["ada", "bob", "eve"]), st.floats(0, 60)), min_size=150, max_size=300))
def test_a_known_browser_is_delayed_by_itself_alone(attempts: list[tuple[str, float]]) -> None:
    """Also while someone at the same address uses up what is allowed there, and no login there succeeds."""
    delays, now = LoginDelays(), 0.0
    delays.attempt("ada", "home", now)
    delays.succeed("ada", "home")
    for name, later in attempts:
        now += later
        delays.attempt(name, "home", now)
    assert [delays.attempt("ada", "home", now, "browser") for _ in range(PAIR.free + 1)] == [0.0] * (PAIR.free + 1)
    assert delays.attempt("ada", "home", now, "browser") == pytest.approx(1.0)
    assert delays.attempt("ada", "elsewhere", now, "browser") > 0.0


def test_at_a_usual_address_a_hundred_failures_of_others_delay_nobody() -> None:
    delays = LoginDelays()
    delays.attempt("ada", "home", 0.0)
    delays.succeed("ada", "home")
    assert all(delays.attempt("ada", "home", 0.0) == 0.0 for _ in range(KNOWN.free))
    assert delays.attempt("other", "home", 0.0) > 0.0  # they count for the address
    assert delays.attempt("ada", "home", 0.0) == 0.0
    assert delays.attempt("ada", "home", 0.0) == 1.0


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 5), st.floats(0, 30)), max_size=400))
def test_guessing_is_bounded_wherever_it_comes_from(attempts: list[tuple[int, int, float]]) -> None:
    """For each name, for each address, and for each name at each address, whatever the rhythm."""
    delays, now = LoginDelays(), 0.0
    delays.attempt("name0", "address0", now)
    delays.succeed("name0", "address0")
    tried: dict[tuple[int | None, int | None], int] = {}
    for name, address, later in attempts:
        now += later
        if delays.attempt(f"name{name}", f"address{address}", now) == 0.0:
            for key in ((name, None), (None, address), (name, address)):
                tried[key] = tried.get(key, 0) + 1
    for (name, address), count in tried.items():  # each doubling lasts as long as all before it
        usual = KNOWN.free + 10 + now / KNOWN.longest if name in (None, 0) and address in (None, 0) else 0
        if name is None:
            assert count <= ADDRESS.free + 10 + now / ADDRESS.longest + usual
        elif address is None:
            assert count <= NAME.free + 6 + now / NAME.longest + usual
        else:
            assert count <= usual or count <= PAIR.free + 10 + now / PAIR.longest


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


def test_no_more_than_so_many_are_remembered() -> None:
    delays = LoginDelays()
    for count in range(MAX_REMEMBERED + 10):
        delays.attempt(f"name{count}", f"{count}", float(count))
        assert len(delays) <= MAX_REMEMBERED
        delays.succeed(f"known{count}", f"{count}")
        assert len(delays) <= MAX_REMEMBERED


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

"""One user's share does not depend on the others, and nothing is limited where nobody is known."""

from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.access import ANYBODY, Principal, PrincipalKind, forwarded
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.http.quotas import MINUTE, Quotas
from dock_gateway.settings import Settings

MOST = 3
SETTINGS = Settings(max_goals_per_minute=MOST, max_streams_per_user=2, max_exports_per_user=1)
ADA, BOB = (Principal(name, PrincipalKind.TOKEN, UNLIMITED, name) for name in ("ada", "bob"))


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def sends(quotas: Quotas, principal: Principal) -> bool:
    try:
        quotas.spend_goal(principal)
    except TooManyRequests as error:
        return error.code != "too_many_goals"
    return True


@given(st.lists(st.tuples(st.sampled_from([ADA, BOB]), st.floats(0, 40)), max_size=40))
def test_no_minute_has_more_goals_of_one_user_and_none_is_refused_without_need(
    attempts: list[tuple[Principal, float]],
) -> None:
    clock = Clock()
    quotas = Quotas(SETTINGS, clock=clock)
    sent: dict[str | None, list[float]] = {"ada": [], "bob": []}
    for principal, pause in attempts:
        clock.now += pause
        recent = [at for at in sent[principal.name] if clock.now - at < MINUTE]
        assert sends(quotas, principal) is (len(recent) < MOST)
        if len(recent) < MOST:
            sent[principal.name].append(clock.now)


def test_streams_and_exports_are_counted_while_they_are_open() -> None:
    quotas = Quotas(SETTINGS)
    with ExitStack() as stack:
        stack.enter_context(quotas.slot(ADA, "streams"))
        stack.enter_context(quotas.slot(ADA, "streams"))
        stack.enter_context(quotas.slot(ADA, "exports"))
        stack.enter_context(quotas.slot(BOB, "streams"))
        for what in ("streams", "exports"):
            with pytest.raises(TooManyRequests) as refused, quotas.slot(ADA, what):
                pass
            assert refused.value.code == f"too_many_{what}"
    with quotas.slot(ADA, "exports"), quotas.slot(ADA, "streams"):
        pass


@pytest.mark.parametrize("anybody", [ANYBODY, forwarded(None, UNLIMITED, "key")])
def test_nobody_is_limited_where_nobody_is_known(anybody: Principal) -> None:
    quotas = Quotas(SETTINGS)
    assert all(sends(quotas, anybody) for _ in range(MOST * 10))
    with ExitStack() as stack:
        for _ in range(10):
            stack.enter_context(quotas.slot(anybody, "exports"))

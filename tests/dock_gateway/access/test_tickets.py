"""A ticket opens one WebSocket, soon."""

from dataclasses import replace

import pytest

from dock_gateway.access.tickets import LIFETIME, MAX_TICKETS, Tickets
from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import NotAuthenticated


class Clock:
    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def tickets(clock: Clock) -> Tickets:
    return Tickets(clock)


def is_valid(tickets: Tickets, ticket: str) -> bool:
    try:
        return tickets.redeem(ticket) is ANYBODY
    except NotAuthenticated:
        return False


def test_the_error_says_what_is_wrong(tickets: Tickets) -> None:
    with pytest.raises(NotAuthenticated) as refused:
        tickets.redeem("x")
    assert refused.value.code == "invalid_ticket"


def test_it_is_valid_once(tickets: Tickets) -> None:
    ticket = tickets.issue(ANYBODY)
    assert len(ticket) >= 43
    assert is_valid(tickets, ticket)
    assert not is_valid(tickets, ticket)


@pytest.mark.parametrize("ticket", ["", "x", "\udcff"])
def test_another_text_is_none(tickets: Tickets, ticket: str) -> None:
    tickets.issue(ANYBODY)
    assert not is_valid(tickets, ticket)


@pytest.mark.parametrize(("seconds", "valid"), [(LIFETIME - 0.1, True), (LIFETIME, False)])
def test_it_expires(tickets: Tickets, clock: Clock, seconds: float, valid: bool) -> None:
    ticket = tickets.issue(ANYBODY)
    clock.now += seconds
    assert is_valid(tickets, ticket) is valid


def test_a_flood_takes_no_more_than_its_share_of_memory(tickets: Tickets) -> None:
    other = replace(ANYBODY, name="other")
    first = tickets.issue(other)
    issued = [tickets.issue(ANYBODY) for _ in range(MAX_TICKETS + 1)]
    assert tickets.redeem(first) == other, "it is that of another user"
    assert not is_valid(tickets, issued[0])
    assert all(is_valid(tickets, ticket) for ticket in issued[1:])

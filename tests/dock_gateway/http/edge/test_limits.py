"""Who may connect: the limits, the reserve, and connections that never end by themselves."""

import resource
from collections.abc import Iterator

import pytest

from dock_gateway.http.edge import limits as edge_limits
from dock_gateway.http.edge.limits import OTHER_FILES, ConnectionLimits, Priority, raise_file_limit
from dock_gateway.settings import Settings
from tests.support.waiting import until


class Connection:
    def __init__(self, address: str = "10.0.0.1", priority: Priority = Priority.IDLE) -> None:
        self.address = address
        self.priority = priority
        self.stuck = False
        self.dropped = False

    def abort(self) -> None:
        self.dropped = True


def limit(connections: int = 40, per_address: int = 1000) -> ConnectionLimits:
    settings = {"max_connections": connections, "max_connections_per_address": per_address, "subscriber_timeout": 0.05}
    return ConnectionLimits(Settings.model_validate(settings))


def fill(limits: ConnectionLimits, count: int, priority: Priority = Priority.IDLE) -> list[Connection]:
    """Connect so many."""
    connections = [Connection(priority=priority) for _ in range(count)]
    for connection in connections:
        limits.admit(connection)
    return connections


async def test_the_last_quarter_is_a_reserve() -> None:
    limits = limit(40)
    assert [limits.admit(Connection()) for _ in range(40)] == [True] * 30 + [False] * 10
    assert len(limits) == 40


async def test_in_the_reserve_the_oldest_makes_room() -> None:
    limits = limit(40)
    connections = fill(limits, 50)
    assert [connection.dropped for connection in connections] == [False] * 30 + [True] * 10 + [False] * 10
    assert len(limits) == 40


async def test_who_is_being_answered_stays_longer_and_who_stops_a_robot_longest() -> None:
    limits = limit(40)
    fill(limits, 30)
    stop, request = fill(limits, 1, Priority.STOP) + fill(limits, 1, Priority.REQUEST)
    fill(limits, 100)
    assert (stop.dropped, request.dropped) == (False, False)
    fill(limits, 100, Priority.REQUEST)
    assert (stop.dropped, request.dropped) == (False, True)


async def test_stops_that_are_not_answered_make_room_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(edge_limits, "monotonic", lambda: now)
    limits = limit(40)
    fill(limits, 30)
    stops = fill(limits, 10, Priority.STOP)
    (late,) = fill(limits, 1)
    assert late.dropped
    assert not any(stop.dropped for stop in stops)
    now = edge_limits.STOP_TAKES + 1
    fill(limits, 1)
    assert [stop.dropped for stop in stops] == [True] + [False] * 9


async def test_an_address_that_has_all_its_places_gets_into_the_reserve() -> None:
    limits = limit(40, per_address=8)
    assert [limits.admit(Connection()) for _ in range(9)] == [True] * 8 + [False]
    assert limits.admit(Connection("10.0.0.2"))


async def test_places_become_free() -> None:
    limits = limit(40, per_address=8)
    connections = fill(limits, 18)
    for connection in connections:
        limits.release(connection)
        limits.release(connection)
    assert len(limits) == 0
    assert limits.admit(Connection())


@pytest.fixture
def file_limit() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


async def test_there_are_never_more_than_files(file_limit: None) -> None:
    limits = limit(4000)
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (OTHER_FILES + 40, hard))
    fill(limits, 100)
    assert len(limits) == 40
    raise_file_limit()
    assert resource.getrlimit(resource.RLIMIT_NOFILE) == (hard, hard)


async def test_who_never_reads_the_rest_is_dropped() -> None:
    limits = limit(40)
    (connection,) = fill(limits, 1)
    connection.stuck = True
    await until(lambda: connection.dropped)
    limits.release(connection)

"""Calls of the service that stops which are cut off."""

from collections.abc import Iterator

import pytest

from tests.extensions.foxglove.door import STOP, client_of
from tests.support.two_robots import ROBOTS, TwoRobots, two_robots

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def world(shared_domain: int) -> Iterator[TwoRobots]:
    with two_robots(shared_domain) as world:
        yield world


def test_calls_that_are_cut_off_stop(world: TwoRobots) -> None:
    with client_of(world.gateway) as viewer:
        service = viewer.service(STOP)
        for data in (b"\x02" + service.to_bytes(4, "little"), b"\x02" + service.to_bytes(4, "little") + b"\xff" * 8):
            viewer.connection.send(data)
            while viewer.next()["op"] not in ("response", "serviceCallFailure"):
                pass
            assert world.held() == ROBOTS

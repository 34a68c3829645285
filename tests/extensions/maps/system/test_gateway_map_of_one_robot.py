"""The map of a robot shows that robot alone: its place comes from `/tf`, which has the frames of all."""

from collections.abc import Iterator

import orjson
import pytest

from tests.support.access import Site, bearer
from tests.support.gateway import RunningGateway, running_program
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def gateway(shared_domain: int, site: Site, root: dict[str, str]) -> Iterator[RunningGateway]:
    everyone = bearer(site.token("everyone", "operator"))
    with (
        running_program(shared_domain, "dock_simulator"),
        running_program(shared_domain, "dock_simulator", "-r", "__ns:=/robot1"),
        site.gateway(shared_domain) as gateway,
    ):
        for robot in ("/", "/robot1"):
            path = f"/map?robot={robot}"
            wait_until(lambda path=path: gateway.http.get(path, headers=everyone).status_code == 200, path)
        yield gateway


def test_the_map_shows_only_the_robot(gateway: RunningGateway, root: dict[str, str]) -> None:
    """The gateway reads `/tf`, and tells of the robot alone."""
    assert gateway.http.get("/map?robot=/robot1", headers=root).json()["code"] == "not_allowed"
    answer = gateway.http.get("/map?robot=/", headers=root)
    assert answer.status_code == 200, answer.text
    assert "robot1" not in orjson.dumps(answer.json()).decode()

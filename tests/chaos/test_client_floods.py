"""While some clients attack, others stop robots, ask for the health and read their streams, and memory comes back."""

import resource
from collections.abc import Iterator

import pytest

from tests.chaos.withstand import withstand
from tests.support.domain import ros_domain
from tests.support.floods import FLOODS, LONG, MAPS, flooding
from tests.support.gateway import RunningGateway, running_gateway, running_hostile_node

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    with ros_domain() as domain:
        yield domain


@pytest.fixture(scope="module")
def started(domain: int) -> Iterator[tuple[RunningGateway, int]]:
    """A gateway, and the number of lines that it logged while it started."""
    with running_gateway(domain, mcp="true", allow_publish="/flood/*") as gateway:
        gateway.wait_until_stored()
        gateway.http.get("/openapi.json").raise_for_status()  # it is made once, which takes memory that is kept
        yield gateway, len(gateway.process.output.splitlines())


@pytest.fixture(scope="module")
def gateway(started: tuple[RunningGateway, int]) -> RunningGateway:
    return started[0]


@pytest.fixture(scope="module")
def gateway_with_few_files() -> Iterator[RunningGateway]:
    with ros_domain() as domain, running_gateway(domain) as gateway:
        resource.prlimit(gateway.process.pid, resource.RLIMIT_NOFILE, (300, 300))
        yield gateway


@pytest.mark.parametrize("name", [name for name in FLOODS if name not in MAPS])
def test_a_flood(gateway: RunningGateway, name: str) -> None:
    megabytes = 60 if name in LONG else 20
    withstand(gateway, f"Clients: {name}", lambda: flooding(name, gateway.url), megabytes)


@pytest.mark.parametrize("name", MAPS)
def test_a_flood_of_large_messages(gateway: RunningGateway, domain: int, name: str) -> None:
    """A map of many megabytes comes each second. Fast DDS keeps buffers of that size."""
    with running_hostile_node(domain, "grid", "--size", f"{MAPS[name]}"):
        withstand(gateway, f"Clients: {name}", lambda: flooding(name, gateway.url), megabytes=300)


@pytest.mark.parametrize("name", ["half-open connections", "half-sent requests", "connections", "slow event streams"])
def test_a_flood_where_files_are_few(gateway_with_few_files: RunningGateway, name: str) -> None:
    """A stop comes by a new connection, and gets through though the attacker takes every one that it can have."""
    gateway = gateway_with_few_files
    withstand(gateway, f"Clients, 300 file descriptors: {name}", lambda: flooding(name, gateway.url))


def test_nothing_of_this_is_logged(started: tuple[RunningGateway, int]) -> None:
    gateway, before = started
    logged = gateway.process.output.splitlines()[before:]
    lines = [line for line in logged if "[WARNING]" in line or "[ERROR]" in line]
    assert lines == []
    assert "Traceback" not in gateway.process.output

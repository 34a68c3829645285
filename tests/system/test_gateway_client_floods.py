"""While some clients attack, others stop robots, ask for the health and read their streams, and memory comes back."""

import os
import resource
import time
from collections.abc import Iterator

import pytest

from tests.support.domain import ros_domain
from tests.support.floods import FLOODS, flooding
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.probe import memory, open_files, probing, quantile

pytestmark = pytest.mark.ros

# The promise is 100 ms; a machine that is shared gets ten times that.
STOPPED_WITHIN = 1.0
SECONDS = float(os.environ.get("FLOOD_SECONDS", "1"))
MEGABYTES = 20


@pytest.fixture(scope="module")
def gateway() -> Iterator[RunningGateway]:
    with ros_domain() as domain, running_gateway(domain) as gateway:
        yield gateway


@pytest.fixture(scope="module")
def gateway_with_few_files() -> Iterator[RunningGateway]:
    with ros_domain() as domain, running_gateway(domain) as gateway:
        resource.prlimit(gateway.process.pid, resource.RLIMIT_NOFILE, (300, 300))
        yield gateway


def withstand(gateway: RunningGateway, name: str) -> None:
    """Measure during a flood."""
    before, files = memory(gateway.process.pid), open_files(gateway.process.pid)
    with probing(gateway) as findings, flooding(name, gateway.url):
        time.sleep(SECONDS)
    print(f"{name}: {findings}")
    assert findings.errors == []
    assert findings.stop
    assert quantile(findings.stop, 0.99) < STOPPED_WITHIN
    assert max(findings.health) < 2 * STOPPED_WITHIN
    assert findings.gaps
    assert max(findings.gaps) < 2 * STOPPED_WITHIN
    deadline = time.monotonic() + 10
    while memory(gateway.process.pid) > before + MEGABYTES or open_files(gateway.process.pid) > files + 10:
        assert time.monotonic() < deadline, (before, memory(gateway.process.pid), open_files(gateway.process.pid))
        time.sleep(0.1)


@pytest.mark.parametrize("name", FLOODS)
def test_a_flood(gateway: RunningGateway, name: str) -> None:
    withstand(gateway, name)


@pytest.mark.parametrize("name", ["half-open connections", "half-sent requests", "connections", "slow event streams"])
def test_a_flood_where_files_are_few(gateway_with_few_files: RunningGateway, name: str) -> None:
    """A stop comes by a new connection, and gets through though the attacker takes every one that it can have."""
    withstand(gateway_with_few_files, name)


def test_nothing_of_this_is_logged(gateway: RunningGateway) -> None:
    lines = [line for line in gateway.process.output.splitlines() if "[WARNING]" in line or "[ERROR]" in line]
    assert lines == []
    assert "Traceback" not in gateway.process.output

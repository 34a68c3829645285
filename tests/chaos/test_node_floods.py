"""While a ROS node floods the gateway, clients stop robots, ask for the health and read their streams."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest

from tests.chaos.withstand import withstand
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_hostile_node
from tests.support.probe import probing
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

# Fast DDS keeps some buffers of the size of the largest message that it has received.
DDS_BUFFERS = 100

FLOODS = {
    "3,000 goals in each status message": ("status_entries", "--count", "3000", "--rate", "2"),
    "3,000 ended goals in each status message": ("ended_entries", "--count", "3000", "--rate", "2"),
    "220 unknown goals a second": ("unknown_goals", "--rate", "220"),
    "feedback of 1,000 unknown goals a second": ("unknown_feedback", "--rate", "1000"),
    "feedback of 10,000 unknown goals a second": ("unknown_feedback", "--rate", "10000"),
    "300 unknown goals in each of 10 status messages a second": ("unknown_statuses", "--count", "300", "--rate", "10"),
    "feedback of 10 MB": ("big_feedback", "--size", "10000000", "--rate", "1"),
    "3,000 battery states a second": ("battery", "--rate", "3000", "--topic", "/hostile/battery_status"),
    "10,000 diagnostics a second": ("diagnostics", "--count", "50", "--rate", "200"),
}
# Nodes that misbehave in different ways at the same time. Each is a process that needs the machine, too.
SEVERAL = (
    ("unknown_feedback", "--rate", "1000"),
    ("unknown_statuses", "--count", "300", "--rate", "10"),
    ("battery", "--rate", "1000", "--topic", "/hostile/battery_status"),
    ("diagnostics", "--count", "50", "--rate", "50"),
    ("velocity", "--rate", "1000", "--topic", "/hostile/cmd_vel"),
    ("churn", "--count", "20", "--rate", "10"),
)


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    with ros_domain() as number:
        yield number


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with running_gateway(domain) as gateway:
        # What the first flood makes the gateway keep for good, such as loaded code and freed memory, is no leak.
        with probing(gateway) as findings, running_hostile_node(domain, *next(iter(FLOODS.values()))):
            wait_until(lambda: findings.complete, "an answer to each probe")
        yield gateway


@pytest.mark.parametrize("name", FLOODS)
def test_a_flood(gateway: RunningGateway, domain: int, name: str) -> None:
    lines = len(gateway.process.output.splitlines())
    megabytes = DDS_BUFFERS if name == "feedback of 10 MB" else 20
    withstand(gateway, f"ROS node: {name}", lambda: running_hostile_node(domain, *FLOODS[name]), megabytes)
    assert len(gateway.process.output.splitlines()) - lines < 2000


@contextmanager
def several_floods(domain: int) -> Iterator[None]:
    with ExitStack() as stack:
        for arguments in SEVERAL:
            stack.enter_context(running_hostile_node(domain, *arguments))
        yield


def test_several_floods_at_once(gateway: RunningGateway, domain: int) -> None:
    withstand(gateway, "ROS nodes: six kinds of misbehaving node at once", lambda: several_floods(domain))

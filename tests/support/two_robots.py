"""A gateway that is configured for one of two robots, and what both are commanded."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import NamedTuple

from geometry_msgs.msg import Twist

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.observer import Observer, Recording, ros_observer
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

ROBOTS = ["/robot1", "/robot2"]
# A stop that is nested more deeply than any reader goes.
DEEP = b'{"robot":' * 2000 + b"1" + b"}" * 2000


class TwoRobots(NamedTuple):
    """The gateway, and what each robot is commanded."""

    gateway: RunningGateway
    commanded: dict[str, Recording]

    def held(self) -> list[str]:
        """Return the robots that are stopped, and release them."""
        robots: list[str] = self.gateway.http.get("/stop").raise_for_status().json()["robots"]
        self.gateway.http.delete("/stop").raise_for_status()
        return robots


@contextmanager
def two_robots(domain: int, **settings: str) -> Iterator[TwoRobots]:
    """Run them."""
    with ExitStack() as stack:
        command = ("-m", "tests.support.robots", "--robots", "2")
        stack.enter_context(ForkedProcess(*command, env=ros_environment(domain)))
        observer: Observer = stack.enter_context(ros_observer(domain))
        commanded = {name: observer.record(Twist, f"{name}/cmd_vel") for name in ROBOTS}
        gateway = stack.enter_context(running_gateway(domain, namespace="/robot1", **settings))
        wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) == 2, "the robots")
        wait_until(lambda: observer.node.count_publishers("/robot2/cmd_vel"), "the gateway on the topic")
        yield TwoRobots(gateway, commanded)

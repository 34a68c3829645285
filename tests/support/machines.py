"""Machines as network namespaces: `gateway`, which is on one network with `robot1` and on another with `robot2`.

`gateway` does not forward packets, so the robots do not reach each other. The namespaces belong to a user namespace:
they need no root where the kernel allows that to users, and end with the processes in them.
"""

import os
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from tests.support.processes import Process
from tests.support.waiting import wait_until

# Seconds after which the namespaces end if the tests are killed.
LASTS = "600"


@dataclass(frozen=True)
class Machine:
    """A network namespace.

    Attributes:
        holder: The process that holds it.
        addresses: Its addresses.
    """

    holder: int
    addresses: tuple[str, ...]

    def command(self, *command: str) -> tuple[str, ...]:
        """Return the command line that runs a command there."""
        return ("nsenter", "--preserve-credentials", "--user", "--net", f"--target={self.holder}", *command)

    def run(self, *command: str) -> str:
        """Run a command there and return its output.

        Raises:
            CalledProcessError: It failed.
        """
        return subprocess.run(self.command(*command), check=True, capture_output=True, text=True).stdout


@dataclass(frozen=True)
class Machines:
    """The three of them."""

    gateway: Machine
    robot1: Machine
    robot2: Machine


@contextmanager
def machines() -> Iterator[Machines]:
    """Create the machines.

    Raises:
        OSError: `unshare` is not installed or not allowed.
        CalledProcessError: The networks could not be made.
    """
    with ExitStack() as stack:

        def hold(*unshare: str) -> int:
            command = (*unshare, "sh", "-c", f"echo held; exec sleep {LASTS}")
            holding = stack.enter_context(Process(*command, env=dict(os.environ)))
            try:
                holding.wait_for("held")
            except AssertionError as error:
                raise OSError(holding.output) from error
            return holding.pid

        gateway = Machine(hold("unshare", "--map-root-user", "--net"), ("192.0.2.1", "198.51.100.1"))
        gateway.run("ip", "link", "set", "lo", "up")
        robots = []
        for address in gateway.addresses:
            robot = Machine(hold(*gateway.command("unshare", "--net")), (address.removesuffix("1") + "2",))
            link = f"robot{len(robots) + 1}"
            gateway.run("ip", "link", "add", link, "type", "veth", "peer", "name", "eth0", "netns", str(robot.holder))
            for machine, end, own in ((gateway, link, address), (robot, "eth0", robot.addresses[0])):
                machine.run("ip", "address", "add", f"{own}/24", "dev", end)
                machine.run("ip", "link", "set", end, "up")
            robot.run("ip", "link", "set", "lo", "up")
            robot.run("ip", "route", "add", "default", "via", address)
            robots.append(robot)
        # DDS uses the interfaces that are up when a participant is made.
        for robot in robots:
            wait_until(lambda robot=robot: _is_up(robot, "eth0"), "a robot's link is up")
        wait_until(lambda: _is_up(gateway, "robot1") and _is_up(gateway, "robot2"), "the gateway's links are up")
        yield Machines(gateway, *robots)


def _is_up(machine: Machine, link: str) -> bool:
    return machine.run("ip", "-brief", "link", "show", link).split()[1] == "UP"

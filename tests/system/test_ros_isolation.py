"""The measures of docs/security.md on the ROS graph: what each keeps out, and what it does not.

The machines are network namespaces. A node that must not be reached stands beside one that is, and that the attacker
drives for longer than DDS takes between two announcements.
"""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.support.domain import ros_domain
from tests.support.gateway import running_gateway
from tests.support.machines import Machine, Machines, machines
from tests.support.observer import Observer
from tests.support.processes import Process, ros_environment
from tests.support.waiting import wait_until

PAGE = Path(__file__).parents[2] / "docs" / "security.md"
# Messages of an attacker, ten a second: in this time a participant announces itself at least once, every 3 s.
ENOUGH = 35

# Starts a peer: on a machine, with the arguments of `tests/support/peer.py`, and the last part of ROS_… variables.
Start = Callable[..., Process]


@pytest.fixture(scope="module")
def lab() -> Iterator[Machines]:
    with ExitStack() as stack:
        try:
            made = stack.enter_context(machines())
        except (OSError, subprocess.CalledProcessError) as error:
            pytest.skip(f"no network namespaces: {error}")
        yield made


@pytest.fixture
def start(domain: int) -> Iterator[Start]:
    with ExitStack() as stack:

        def start(
            machine: Machine,
            name: str,
            *speed: float,
            inside: tuple[str, ...] = (),
            discovery: str = "SUBNET",
            peers: str = "",
            **more: str,
        ) -> Process:
            variables = {"ROS_AUTOMATIC_DISCOVERY_RANGE": discovery, "ROS_STATIC_PEERS": peers, **more}
            command = (*inside, sys.executable, "-m", "tests.support.peer", name, *map(str, speed))
            peer = Process(*machine.command(*command), env=ros_environment(domain, **variables))
            return stack.enter_context(peer)

        yield start


def driven(peer: Process, speed: float) -> int:
    """How many messages with this speed have reached it."""
    return peer.output.splitlines().count(f"driven at {speed}")


def wait_until_driven(peer: Process, speed: float, times: int = 1) -> None:
    wait_until(lambda: driven(peer, speed) >= times, f"a node that is driven at {speed}")


def is_spared(robot: Process, speed: float, *, beside: Process) -> bool:
    """Whether nothing drives a robot at this speed, while that does drive another node."""
    robot.wait_for("finds")  # itself: it is on the graph
    wait_until_driven(beside, speed, driven(beside, speed) + ENOUGH)
    return not driven(robot, speed)


def finds(peer: Process, name: str) -> bool:
    return f"finds {name}" in peer.output.splitlines()


def test_another_domain_hides_a_robot_until_its_number_is_used(lab: Machines, start: Start, domain: int) -> None:
    with ros_domain() as other:
        robot = start(lab.gateway, "robot")
        beside = start(lab.gateway, "beside", ROS_DOMAIN_ID=str(other))
        start(lab.robot1, "attacker", 0.1, ROS_DOMAIN_ID=str(other))
        assert is_spared(robot, 0.1, beside=beside)

        start(lab.robot1, "attacker", 0.2, ROS_DOMAIN_ID=str(domain))
        wait_until_driven(robot, 0.2)


def test_localhost_hides_a_robot_until_its_machine_is_named(lab: Machines, start: Start) -> None:
    robot = start(lab.gateway, "robot", discovery="LOCALHOST")
    off = start(lab.gateway, "off", discovery="OFF", peers=lab.robot1.addresses[0])
    beside = start(lab.gateway, "beside", discovery="SUBNET")
    attacker = start(lab.robot1, "attacker", 0.1)
    assert is_spared(robot, 0.1, beside=beside)
    assert not finds(attacker, "robot")

    attacker = start(lab.robot1, "another", 0.2, peers=lab.gateway.addresses[0])
    assert is_spared(off, 0.2, beside=robot)
    assert not driven(off, 0.1)
    assert not finds(attacker, "off")


def test_static_peers_find_whom_they_name_and_answer_whoever_names_them(lab: Machines, start: Start) -> None:
    named, stranger = lab.robot1, lab.robot2
    robot = start(lab.gateway, "robot", discovery="LOCALHOST", peers=named.addresses[0])
    beside = start(lab.gateway, "beside", discovery="SUBNET")
    start(named, "named", 0.1, discovery="LOCALHOST")
    start(stranger, "stranger", 0.2)
    wait_until_driven(robot, 0.1)
    assert is_spared(robot, 0.2, beside=beside)

    start(stranger, "another", 0.3, peers=lab.gateway.addresses[1])
    wait_until_driven(robot, 0.3)


def test_a_firewall_keeps_out_who_names_the_machine(lab: Machines, start: Start, domain: int) -> None:
    first = 7400 + 250 * domain
    rules = block("nft").replace("7400-7649", f"{first}-{first + 249}")
    assert str(first) in rules
    assert lab.robot1.addresses[0] in rules
    try:
        lab.gateway.run("nft", rules)
    except subprocess.CalledProcessError as error:
        if "such file" in error.stderr:
            pytest.skip("nft is not installed")
        raise
    robot = start(lab.gateway, "robot")
    stranger = start(lab.robot2, "stranger", 0.1, peers=lab.gateway.addresses[1])
    start(lab.robot1, "named", 0.2)
    stranger.wait_for("finds")
    wait_until_driven(robot, 0.2, ENOUGH)
    assert not driven(robot, 0.1)
    assert not finds(stranger, "robot")

    lab.gateway.run("nft", "delete table inet ros")
    wait_until_driven(robot, 0.1)


def test_a_robot_on_a_network_of_its_own_is_reached_by_the_gateway_alone(lab: Machines, start: Start) -> None:
    gateway, robot = start(lab.gateway, "gateway"), start(lab.robot1, "robot")
    attacker = start(lab.robot2, "attacker", 0.1, peers=lab.robot1.addresses[0])
    robot.wait_for("finds gateway")
    assert is_spared(robot, 0.1, beside=gateway)
    assert not finds(attacker, "robot")

    forward = "echo {} > /proc/sys/net/ipv4/ip_forward"
    lab.gateway.run("sh", "-c", forward.format(1))
    try:
        wait_until_driven(robot, 0.1)
    finally:
        lab.gateway.run("sh", "-c", forward.format(0))


def test_shared_memory_of_its_own_keeps_no_process_of_the_same_network_out(lab: Machines, start: Start) -> None:
    robot = start(lab.gateway, "robot", discovery="LOCALHOST")
    apart = ("unshare", "--mount", "sh", "-c", 'mount -t tmpfs tmpfs /dev/shm && exec "$@"', "sh")
    start(lab.gateway, "attacker", 0.1, inside=apart, peers="127.0.0.1", FASTDDS_BUILTIN_TRANSPORTS="UDPv4")
    wait_until_driven(robot, 0.1)


@pytest.mark.parametrize("strategy", ["Enforce", "Permissive"])
def test_dds_security_is_not_built_in(domain: int, tmp_path: Path, strategy: str) -> None:
    (tmp_path / "enclaves").mkdir()
    secure = {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": strategy,
        "ROS_SECURITY_KEYSTORE": str(tmp_path),
    }
    command = (sys.executable, "-m", "tests.support.peer", "robot")
    with Process(*command, env=ros_environment(domain, **secure)) as robot:
        assert robot.wait() == 1
    assert "This Fast DDS version doesn't have the security libraries" in robot.output


def test_without_a_keystore_a_node_runs_unprotected_unless_security_is_enforced(domain: int) -> None:
    command = (sys.executable, "-m", "tests.support.peer", "robot")
    with Process(*command, env=ros_environment(domain, ROS_SECURITY_ENABLE="true")) as robot:
        robot.wait_for("finds robot")
    enforced = ros_environment(domain, ROS_SECURITY_ENABLE="true", ROS_SECURITY_STRATEGY="Enforce")
    with Process(*command, env=enforced) as robot:
        assert robot.wait() == 1


def test_the_policy_covers_what_the_gateway_uses(domain: int, observer: Observer) -> None:
    with running_gateway(domain):
        node = observer.node
        wait_until(lambda: "dock_gateway" in node.get_node_names(), "the gateway's node")

        def used(kind: str) -> set[str]:
            found = getattr(node, f"get_{kind}_names_and_types_by_node")("dock_gateway", "/")
            return {name for name, _ in found}

        wait_until(lambda: any("undock" in n or "disconnect" in n for n in used("client")), "its last client")
        assert used("publisher") <= allowed("topic", "publish")
        assert used("subscriber") <= allowed("topic", "subscribe") | of_actions("feedback", "status")
        assert used("client") <= allowed("service", "request") | of_actions("send_goal", "get_result", "cancel_goal")
        assert used("service") <= allowed("service", "reply")


def block(language: str) -> str:
    """The page's example in this language."""
    found = re.search(f"```{language}\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert found is not None, language
    return found[1]


def allowed(kind: str, right: str) -> set[str]:
    """The names of topics, services or actions for which the page's policy gives this right."""
    entries = ET.fromstring(block("xml")).findall(f".//{kind}s[@{right}='ALLOW']/{kind}")
    return {re.sub("^~/|^(?=[^/])", lambda part: "/dock_gateway/" if part[0] else "/", e.text or "") for e in entries}


def of_actions(*parts: str) -> set[str]:
    return {f"{action}/_action/{part}" for action in allowed("action", "call") for part in parts}

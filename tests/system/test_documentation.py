"""The commands in README.md and docs/ work: each block is run as it stands, or a comment says why it is not."""

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path

import pytest

from docking.simulation.hall import Hall
from tests.support.access import PASSWORD, Site, bearer
from tests.support.certificates import Authority
from tests.support.gateway import (
    RunningGateway,
    ready_gateway,
    running_gateway,
    running_program,
    running_servers,
)
from tests.support.installed import needs
from tests.support.pages import PAGES, Block, blocks
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = [needs("simulator"), pytest.mark.ros]

BLOCKS = [block for page in PAGES for block in blocks(page) if not block.reason]
FLEET = ("/robot1", "/robot2", "/robot3")
# The robots start on their docks: to dock takes no time then.
DOCKED = {"x": -0.2, "y": 0.0, "theta": 0.0}
# What a shell reads before the commands: a gateway ends as soon as it listens, `<goal_id>` is the last goal, and what
# runs in the background ends with the block.
SHELL = rf"""
set -eo pipefail
trap '{{ kill $(jobs -p) && wait; }} 2> /dev/null || true' EXIT
dock-gateway() {{
    if [ "$1" != serve ]; then command dock-gateway "$@" <<< "{PASSWORD}"; return; fi
    command dock-gateway "$@" > serve.log 2>&1 &
    until grep -q "listening on" serve.log; do kill -0 $! || {{ cat serve.log; return 1; }}; sleep 0.1; done
    kill $!
    wait $! || [ $? = 143 ]
}}
goal_id() {{ curl "$DOCK_GATEWAY_URL/goals?limit=1" | grep -oP '"goal_id":"\K[^"]+'; }}
"""


def is_up(gateway: RunningGateway, robot: str) -> bool:
    """Whether a robot has its servers, and its simulator answers."""
    if gateway.http.get("/simulator", params={"robot": robot}).status_code != 200:
        return False
    (state,) = gateway.http.get("/robots", params={"robot": robot}).raise_for_status().json()["robots"]
    return all(state[verb] and state[verb]["available"] for verb in ("dock", "undock"))


@contextmanager
def simulated_robot(domain: int) -> Iterator[None]:
    """As `dock-gateway up` starts it."""
    docked = [text for name, value in DOCKED.items() for text in ("-p", f"start_{name}:={value}")]
    with (
        running_program(domain, "docking_server", "-p", "controller:=dock_pose"),
        running_program(domain, "dock_simulator", *docked),
    ):
        yield


@contextmanager
def simulated(domain: int, _: dict[str, str]) -> Iterator[RunningGateway]:
    """As `dock-gateway up`, with three more robots and an action of the tutorial."""
    fleet = ("-m", "docking.nodes.simulated_fleet", str(len(FLEET)))
    with (
        running_gateway(domain, mcp="true") as gateway,
        simulated_robot(domain),
        running_program(domain, "fibonacci_action_server"),
        ForkedProcess(*fleet, env=ros_environment(domain)),
    ):
        wait_until(lambda: all(is_up(gateway, robot) for robot in ("/", *FLEET)), "the robots")
        for number, robot in enumerate(FLEET, 1):
            docked = {**DOCKED, "y": Hall(len(FLEET), len(FLEET)).docked(number).y}
            gateway.http.post("/simulator/place", params={"robot": robot}, json=docked).raise_for_status()
        yield gateway


@contextmanager
def tutorial(domain: int, _: dict[str, str]) -> Iterator[RunningGateway]:
    """As `dock-gateway up --no-sim`."""
    with ready_gateway(domain) as gateway:
        yield gateway


@contextmanager
def nav2(domain: int, _: dict[str, str]) -> Iterator[RunningGateway]:
    """A robot with nav2's docking server."""
    pytest.importorskip("nav2_msgs", reason="`make test` installs the interface packages of tests/interfaces")
    with running_servers(domain, "--offer", "nav2"), running_gateway(domain) as gateway:
        wait_until(lambda: gateway.http.get("/readyz").json()["action_server"]["action_name"] == "/dock_robot", "nav2")
        gateway.wait_until_ready()
        yield gateway


@contextmanager
def logins(domain: int, environment: dict[str, str]) -> Iterator[RunningGateway]:
    """A gateway that asks for a login. The commands use its database, and the token of an admin."""
    site = Site(Path(environment["HOME"]))
    token = site.token("test", "admin")
    environment |= {"DOCK_GATEWAY_DATABASE_URL": site.database, "TOKEN": token}
    with simulated_robot(domain), site.gateway(domain) as gateway:
        wait_until(lambda: gateway.http.get("/robots", headers=bearer(token)).status_code == 200, "the token")
        gateway.wait_until_ready()
        yield gateway


GATEWAYS = {"simulated": simulated, "tutorial": tutorial, "nav2": nav2, "logins": logins}


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """The folder in which the commands run: that of a user, with our programs in .venv, and certificates."""
    (tmp_path / ".venv").symlink_to(sys.prefix)
    (tmp_path / ".curlrc").write_text("fail-with-body\nsilent\nshow-error\n")
    pair = Authority(tmp_path).issue()
    (tmp_path / "fullchain.pem").symlink_to(pair.cert)
    (tmp_path / "privkey.pem").symlink_to(pair.key)
    return tmp_path


def run(block: Block, gateway: RunningGateway, environment: dict[str, str]) -> str:
    """Run a block. Return what went wrong, which is empty if each command ended with 0."""
    address = gateway.url.removeprefix("http://")
    text = re.sub(r"(localhost|127\.0\.0\.1):8000", address, block.commands).replace("<goal_id>", "$(goal_id)")
    command = (sys.executable, "-c", text) if block.python else ("bash", "-c", SHELL + text)
    with Process(*command, env=environment, cwd=Path(environment["HOME"])) as process:
        code = process.wait()
    return "" if code == 0 else f"{block.place} ends with {code}:\n{block.commands}\n{process.output}"


def test_each_block_is_for_a_gateway_that_is_there() -> None:
    assert {block.gateway for block in BLOCKS} == set(GATEWAYS)


@pytest.mark.parametrize("kind", GATEWAYS)
def test_the_commands_work(kind: str, domain: int, home: Path) -> None:
    """Those of each page in order, one page after the other, with one gateway."""
    environment = ros_environment(domain, HOME=str(home), DOCK_GATEWAY_PORT="0")
    failures = []
    with GATEWAYS[kind](domain, environment) as gateway:
        environment["DOCK_GATEWAY_URL"] = gateway.url
        for _, page in groupby((block for block in BLOCKS if block.gateway == kind), key=lambda block: block.page):
            failures += [failure for block in page if (failure := run(block, gateway, environment))]
            if kind == "simulated":
                gateway.stop_once()
                gateway.http.post("/simulator/reset").raise_for_status()
    assert not failures, "\n\n".join(failures)

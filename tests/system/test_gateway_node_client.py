"""The TypeScript client in Node.js, installed from its package, at a real gateway over connections that break."""

import os
import shutil
import subprocess
import tarfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from dock_gateway import __version__
from tests.support.gateway import CHARGING, LOW, RunningGateway, ready_gateway
from tests.support.proxy import proxy
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

ROOT = Path(__file__).parents[2]
FOLLOW = """
import { Client } from "@dock-gateway/client";
const goal = await new Client().dock();
for await (const event of goal.events()) if (event.type === "feedback") console.log(event.id);
console.log((await goal.result()).goal_id);
"""


def in_node(command: str, folder: Path) -> list[str]:
    """How a shell command is run in a folder with the Node.js that builds the dashboard.

    Before version 22 its WebSocket has to be switched on.
    """
    setup = f". '{ROOT}/scripts/node-env' && export NODE_OPTIONS=--experimental-websocket && cd '{folder}'"
    return ["bash", "-c", f"{setup} && exec {command}"]


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with ready_gateway(shared_domain) as gateway:
        yield gateway


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the client and its dependencies are installed."""
    folder = tmp_path_factory.mktemp("node")
    installed = folder / "node_modules"
    subprocess.run(in_node(f"npm pack --silent --pack-destination '{folder}' ./frontend/client", ROOT), check=True)
    with tarfile.open(folder / f"dock-gateway-client-{__version__}.tgz") as archive:
        archive.extractall(folder, filter="data")
    (installed / "@dock-gateway").mkdir(parents=True)
    (folder / "package").rename(installed / "@dock-gateway/client")
    for name in ("openapi-fetch", "openapi-typescript-helpers", "partysocket", "event-target-polyfill"):
        (installed / name).symlink_to(ROOT / "frontend/node_modules" / name)
    shutil.copy(ROOT / "examples/dock.mjs", folder)
    (folder / "follow.mjs").write_text(FOLLOW)
    return folder


def test_a_goal_is_followed_over_broken_connections(gateway: RunningGateway, project: Path) -> None:
    gateway.publish(LOW)
    lines: list[str] = []
    with proxy(gateway.url) as between:
        environment = {**os.environ, "DOCK_GATEWAY_URL": between.url}
        command = in_node("node follow.mjs", project)
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as program:
            assert program.stdout
            for line in program.stdout:
                lines.append(line.strip())
                if len(lines) in (2, 4):
                    between.cut()
                if len(lines) == 6:
                    gateway.publish(CHARGING)
    *seen, goal_id = lines

    def stored() -> list[str]:
        query = {"type": "feedback", "limit": "5000"}
        events = gateway.http.get(f"/goals/{goal_id}/history", params=query).raise_for_status().json()["events"]
        return [event["id"] for event in events if event["id"] >= seen[0]]

    wait_until(lambda: stored() == seen, "what was followed, in the history")


def test_the_example(gateway: RunningGateway, project: Path) -> None:
    gateway.publish(CHARGING)
    environment = {**os.environ, "DOCK_GATEWAY_URL": gateway.url}
    printed = subprocess.check_output(in_node("node dock.mjs", project), env=environment, text=True)
    assert printed.endswith("succeeded\n")

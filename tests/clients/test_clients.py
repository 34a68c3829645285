"""Clients of rosbridge, Foxglove and MCP as their users install them, on a real gateway: `make test-clients`."""

import json
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import sync_playwright

from tests.browser.conftest import ARGUMENTS, CHROMIUM, MISSING
from tests.clients.installed import CLIENTS, HERE, ROOT
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_program, running_talker
from tests.support.installed import needs
from tests.support.origins import blank_page
from tests.support.processes import free_port
from tests.support.waiting import wait_until

pytestmark = needs("rosbridge", "foxglove", "agents")

# The port that the tests of roslibpy expect.
PORT = 9090
BUNDLER = ROOT / "frontend/node_modules/.bin/rolldown"
ENTRY = """
import * as roslib from "{package}";
import {{ scenario }} from "{scenario}";
globalThis.scenario = (url) => scenario("{package}" === "roslib" && roslib.default || roslib, url);
"""


AGENT = """
import {{ Client }} from "@modelcontextprotocol/{client}";
import {{ StreamableHTTPClientTransport }} from "@modelcontextprotocol/{transport}";
globalThis.agent = async (url) => {{
  const client = new Client({{ name: "page", version: "1" }});
  await client.connect(new StreamableHTTPClientTransport(new URL(url)));
  const tools = (await client.listTools()).tools.map((tool) => tool.name);
  const robots = await client.callTool({{ name: "list_robots", arguments: {{}} }});
  await client.close();
  return {{ tools, robots: robots.structuredContent }};
}};
"""


@pytest.fixture(scope="module")
def gateway() -> Iterator[RunningGateway]:
    with ros_domain() as domain, ExitStack() as stack:
        topic = "scan:sensor_msgs/msg/LaserScan:20"
        stack.enter_context(running_talker(domain, "--long", "720", "--topic", topic))
        stack.enter_context(running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.3"))
        gateway = stack.enter_context(
            running_gateway(domain, rosbridge_port=str(PORT), allow_publish="/chatter,/points")
        )
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        wait_until(lambda: gateway.http.get("/graph/topics/talker0/scan").status_code == 200, "the topic")
        yield gateway


@pytest.mark.usefixtures("gateway")
@pytest.mark.parametrize("transport", ["twisted", "asyncio"])
def test_the_own_tests_of_roslibpy(transport: str) -> None:
    command = [CLIENTS / "python/bin/python", "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/ros2"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        command,
        cwd=CLIENTS / "roslibpy",
        env={**environment, "ROSLIBPY_TRANSPORT": transport},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("version", ["2.1.0", "1.4.1"])
def test_roslib_on_node(gateway: RunningGateway, version: str) -> None:
    node = shutil.which("node") or "node"
    url = f"{gateway.url.replace('http', 'ws')}/rosbridge"
    command = [node, HERE / "run.mjs", CLIENTS / version, url]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    check(json.loads(done.stdout.splitlines()[-1]), actions=version == "2.1.0")


@pytest.mark.skipif(CHROMIUM is None, reason=MISSING)
@pytest.mark.parametrize("version", ["2.1.0", "1.4.1"])
def test_roslib_in_chromium(gateway: RunningGateway, tmp_path: Path, version: str) -> None:
    script = bundle(tmp_path, version)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        page = browser.new_context(bypass_csp=True).new_page()
        page.goto(f"{gateway.url}/healthz")
        page.add_script_tag(path=script)
        seen = page.evaluate("(url) => scenario(url)", f"{gateway.url.replace('http', 'ws')}/rosbridge")
        browser.close()
    check(seen, actions=version == "2.1.0")


def bundle(folder: Path, version: str) -> Path:
    """One script of roslib and the scenario."""
    roslib = CLIENTS / version / "node_modules/roslib"
    package = roslib / ("dist/RosLib.js" if version == "2.1.0" else "src/RosLib.js")
    entry, script = CLIENTS / version / "entry.mjs", folder / "script.js"
    entry.write_text(ENTRY.format(package=package, scenario=HERE / "scenario.mjs"))
    command = [BUNDLER, entry, "--file", script, "--format", "iife", "--platform", "browser"]
    done = subprocess.run(command, cwd=CLIENTS / version, capture_output=True, text=True, timeout=60, check=False)
    assert script.exists(), done.stdout + done.stderr
    return script


def check(seen: dict[str, Any], *, actions: bool) -> None:
    """What the scenario has seen; roslib 1 knows no actions of ROS 2."""
    assert "/talker0/scan" in seen["topics"]
    assert seen["twist"]["linear"] == {"x": "double", "y": "double", "z": "double"}
    assert seen["scans"]["none"] == seen["scans"]["png"] == ["Array", 720, 5]
    assert seen["scans"]["cbor"] == ["Float32Array", 720, 5]
    assert seen["scans"]["cbor-raw"][0] == "Uint8Array"
    assert seen["version"] == 2
    assert "/nobody" in seen["refused"]
    assert seen["chatter"] == {"data": "hello"}
    assert "--allow-publish '/cmd_vel'" in seen["statuses"][-1]
    if actions:
        assert seen["result"] == {"sequence": [0, 1, 1, 2, 3]}
        assert seen["feedback"] == {"partial_sequence": [0, 1, 1]}
        assert "canceled" in seen["canceled"]


@pytest.mark.skipif(CHROMIUM is None, reason=MISSING)
@pytest.mark.parametrize("package", ["sdk", "client"])
def test_an_agent_in_a_page_of_another_origin(tmp_path: Path, package: str) -> None:
    """Both versions of the protocol's own client for browsers, as its inspector uses it without a proxy."""
    modules = {"sdk": ("sdk/client/index.js", "sdk/client/streamableHttp.js"), "client": ("client", "client")}
    client, transport = modules[package]
    entry, script = CLIENTS / "mcp/entry.mjs", tmp_path / "script.js"
    entry.write_text(AGENT.format(client=client, transport=transport))
    command = [BUNDLER, entry, "--file", script, "--format", "iife", "--platform", "browser"]
    done = subprocess.run(command, cwd=CLIENTS / "mcp", capture_output=True, text=True, timeout=60, check=False)
    assert script.exists(), done.stdout + done.stderr
    with blank_page() as origin, ros_domain() as domain, sync_playwright() as playwright, ExitStack() as stack:
        gateway = stack.enter_context(running_gateway(domain, mcp="true", allowed_origins=origin))
        page = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS).new_page()
        page.goto(origin)
        page.add_script_tag(path=script)
        seen = page.evaluate("(url) => agent(url)", f"{gateway.url}/mcp")
    assert "stop_robots" in seen["tools"]
    assert [robot["name"] for robot in seen["robots"]["robots"]] == ["/"]


def test_ros_mcp(gateway: RunningGateway) -> None:
    """An agent with ros-mcp sees topics, sends a goal, and is refused what moves a robot past the stop."""
    command = [CLIENTS / "ros-mcp/bin/python", HERE / "agent.py", CLIENTS / "ros-mcp/bin/ros-mcp", str(PORT)]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert "/talker0/scan" in seen["get_topics"]["topics"]
    assert len(seen["subscribe_once"]["msg"]["ranges"]) == 720
    assert seen["send_action_goal"]["result"] == {"sequence": [0, 1, 1, 2, 3]}
    assert "--allow-publish '/cmd_vel'" in seen["publish_for_durations"]["errors"][0]
    assert gateway.http.get("/actions/fibonacci/goals").json()["goals"][0]["status"] == "succeeded"


def test_foxglove_on_node() -> None:
    """Foxglove's client and decoders see a docking, send its goal, set parameters and publish, as far as allowed."""
    allowed = {
        "allow_publish": "/chatter",
        "allow_services": "/dock_simulator/*",
        "allow_parameters": "/dock_simulator",
    }
    own, other = "/dock_simulator.use_sim_time", "/docking_server.use_sim_time"
    with ros_domain() as domain, ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator"))
        stack.enter_context(running_program(domain, "docking_server", "-p", "controller:=dock_pose"))
        port = str(free_port())
        gateway = stack.enter_context(running_gateway(domain, foxglove_port=port, **allowed))
        gateway.wait_until_ready()
        command = [shutil.which("node") or "node", HERE / "viewer.mjs", CLIENTS / "foxglove", f"ws://127.0.0.1:{port}"]
        done = subprocess.run([*command, own, other], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert seen["failed"] == {}
    assert {"/battery_status", "/odom", "/connect_to_charging_dock/_action/feedback", "/diagnostics"} < {
        *seen["topics"]
    }
    assert seen["ended"] == {"goal_id": seen["sent"]["goal_id"], "status": "succeeded", "error": ""}
    assert seen["battery"] == 1
    assert "UUID" in seen["unknown"]
    assert seen["parameters"] == [{"name": own, "value": False}]
    assert other.partition(".")[0] in seen["refused"]
    assert seen["chatter"] == "hello"


def program(number: int) -> str:
    """A program of docs/clients.md that uses roslib, roslibpy or Foxglove's client."""
    page = (ROOT / "docs/clients.md").read_text()
    blocks = re.findall(r"^```(?:python|javascript)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    return [block for block in blocks if "/rosbridge" in block or "/foxglove" in block][number]


@pytest.mark.parametrize(
    ("number", "folder", "name", "expected"),
    [
        (0, "python", "program.py", "[0, 1, 1, 2, 3, 5]"),
        (1, "2.1.0", "program.mjs", "[0,1,1,2,3,5]"),
        (2, "1.4.1", "program.cjs", "/talker0/scan"),
        (3, "foxglove", "program.cjs", "[0,1,1,2,3,5]"),
    ],
)
def test_the_programs_of_the_documentation(
    gateway: RunningGateway, number: int, folder: str, name: str, expected: str
) -> None:
    file = CLIENTS / folder / name
    file.write_text(program(number).replace("127.0.0.1:8000", gateway.url.removeprefix("http://")))
    runtime = CLIENTS / "python/bin/python" if name.endswith(".py") else shutil.which("node") or "node"
    environment = {each: value for each, value in os.environ.items() if not each.startswith("PYTHON")}
    done = subprocess.run([runtime, file], env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert expected in done.stdout

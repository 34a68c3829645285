"""The Python client at a real gateway, over connections that break; and each of the examples."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import aclosing
from importlib.util import find_spec
from pathlib import Path

import orjson
import pytest

from dock_gateway.client import AsyncClient, Client, GatewayRefused, GoalFailed
from tests.support.gateway import CHARGING, LOW, RunningGateway, ready_gateway
from tests.support.proxy import Proxy, proxy
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

EXAMPLES = Path(__file__).parents[2] / "examples"
PLOTS_NOTHING = """
import sys, unittest.mock
plot = unittest.mock.MagicMock()
plot.subplots.return_value = plot, plot
sys.modules |= {"matplotlib": unittest.mock.MagicMock(pyplot=plot), "matplotlib.pyplot": plot}
"""


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with ready_gateway(shared_domain) as gateway:
        yield gateway


@pytest.fixture(scope="module")
def between(gateway: RunningGateway) -> Iterator[Proxy]:
    with proxy(gateway.url) as between:
        yield between


def feedback_of(gateway: RunningGateway, goal_id: str, first: str) -> list[str]:
    """The ids of a goal's feedback, from one on."""
    query = {"type": "feedback", "limit": 5000}
    events = gateway.http.get(f"/goals/{goal_id}/history", params=query).raise_for_status().json()["events"]
    return [event["id"] for event in events if event["id"] >= first]


def run_example(gateway: RunningGateway, *arguments: str | Path) -> str:
    """What it prints."""
    ran = subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, "DOCK_GATEWAY_URL": gateway.url, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    return ran.stdout.strip()


def cells_of(notebook: Path) -> str:
    """A notebook as a program. Where matplotlib is not installed, it plots nothing."""
    cells = orjson.loads(notebook.read_bytes())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    if find_spec("matplotlib") is None:
        code.insert(0, PLOTS_NOTHING)
    return "\n".join(code)


async def test_asyncio_follows_cancels_and_is_refused(gateway: RunningGateway, between: Proxy) -> None:
    gateway.publish(LOW)
    async with AsyncClient(between.url) as client:
        goal = await client.dock()
        with pytest.raises(GatewayRefused) as refusal:
            await client.dock()
        assert (refusal.value.status, refusal.value.code) == (409, "dock_busy")
        count = 0
        async for feedback in goal:
            assert feedback["current_battery_state"]["power_supply_status"] == 3
            count += 1
            if count == 2:
                between.cut()
            if count == 4:
                await goal.cancel()
        with pytest.raises(GoalFailed, match="canceled"):
            await goal
        async with aclosing(client.events(include="robots")) as events:
            snapshot = await anext(events)
        (robot,) = snapshot.document["robots"]
        assert [each.name for each in await client.robots()] == [robot["name"]]
        assert (await client.battery()).percentage == pytest.approx(0.24)


def test_a_goal_is_followed_over_broken_connections(gateway: RunningGateway, between: Proxy) -> None:
    gateway.publish(LOW)
    with Client(between.url) as client:
        goal = client.dock({"desired_battery_state": CHARGING}, key="once")
        assert client.dock({"desired_battery_state": CHARGING}, key="once").id == goal.id
        with pytest.raises(TimeoutError):
            goal.wait(timeout=0.1)
        seen = []
        for event in goal.events():
            if event.type == "feedback":
                seen.append(event.id)
                if len(seen) in (2, 4):
                    between.cut()
                if len(seen) == 6:
                    gateway.publish(CHARGING)
        between.cut()
        state = goal.result()
        assert state.result
        assert state.result["final_battery_state"]["power_supply_status"] == 1
    wait_until(lambda: feedback_of(gateway, goal.id, seen[0]) == seen, "what was followed, in the history")
    assert run_example(gateway, EXAMPLES / "voltage.py").endswith("#" * 22)


def test_examples(gateway: RunningGateway) -> None:
    gateway.publish(CHARGING)
    assert run_example(gateway, EXAMPLES / "dock.py").endswith("succeeded")
    assert run_example(gateway, EXAMPLES / "fleet.py") == "/ succeeded"
    shown = run_example(gateway, "-c", cells_of(EXAMPLES / "battery.ipynb"))
    assert re.fullmatch(r"[1-9]\d* points, \d+ dockings", shown)


def test_a_change_that_somebody_else_has_made_is_not_lost(gateway: RunningGateway) -> None:
    label, at = {"display_name": "Ada's", "groups": []}, {"robot": "/robot1"}
    with Client(gateway.url) as client:
        first = client.request("PUT", "/label", label, params=at)
        client.request("PUT", "/label", {**label, "display_name": "Bob's"}, params=at, if_match=first["etag"])
        with pytest.raises(GatewayRefused) as refusal:
            client.request("PUT", "/label", label, params=at, if_match=first["etag"])
        assert (refusal.value.status, refusal.value.code) == (412, "changed_meanwhile")

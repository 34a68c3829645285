"""A hub waits for a site as long as the request asks the site to wait: for a person, a goal's end, a service."""

import asyncio
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.support.access import Site, bearer
from tests.support.agents import agent, answer
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.hubs import RunningHub, running_hub, site_settings
from tests.support.installed import needs
from tests.support.nats import nats_server
from tests.support.waiting import wait_until

pytestmark = [pytest.mark.ros, needs("agents")]

ACTION = "/fibonacci"
# Seconds: longer than a hub waits for a site that shows no sign of life.
LONG = 12.0


class World(NamedTuple):
    site: RunningGateway
    hub: RunningHub
    agent: str
    operator: str


@pytest.fixture(scope="module")
def world(shared_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    folder: Path = tmp_path_factory.mktemp("hub")
    users = Site(folder, f"sqlite:///{folder}/hub.db")
    tokens = [users.token(name, role) for name, role in (("bot", "agent"), ("ada", "operator"))]
    with (
        nats_server(folder) as nats,
        running_program(shared_domain, "fibonacci_action_server", "-p", "step_period:=3.0"),
        running_gateway(shared_domain, mcp="true", **site_settings(nats.url, folder, "berlin")) as site,
        running_hub(nats.url, folder, authentication="true") as hub,
    ):
        hub.http.headers.update(bearer(tokens[1]))
        hub.wait_for_site("berlin")
        wait_until(lambda: site.http.get(f"/actions{ACTION}").json().get("answering"), "the action")
        yield World(site, hub, *tokens)


def waiting(world: World) -> dict[str, Any]:
    """The goal that waits for a person."""

    def found() -> dict[str, Any] | None:
        approvals = world.site.http.get("/approvals").json()["approvals"]
        return approvals[0] if approvals else None

    return wait_until(found, "an approval")


async def allow_late(world: World) -> float:
    """Allow what waits, after a long time; the time when that was."""
    approval = await asyncio.to_thread(waiting, world)
    assert approval["agent"] == "hub:bot"
    await asyncio.sleep(LONG)
    assert world.site.http.put(f"/approvals/{approval['id']}/decision", json={"allow": True}).is_success
    return time.monotonic()


async def test_a_goal_that_waits_for_a_person(world: World) -> None:
    headers = bearer(world.agent)
    post = world.hub.http.post
    url = f"/sites/berlin/actions{ACTION}/goals"
    sending = asyncio.create_task(asyncio.to_thread(post, url, json={"order": 1}, headers=headers))
    await allow_late(world)
    sent = await sending
    assert sent.status_code == 202, sent.text


async def test_a_call_of_an_agent_that_waits_for_a_person_and_for_the_end(world: World) -> None:
    mcp = RunningGateway(world.site.process, f"{world.hub.url}/sites/berlin", world.hub.http)
    async with agent(mcp, world.agent) as client:
        calling = asyncio.create_task(
            client.call_tool("send_goal", {"action": ACTION, "goal": {"order": 5}, "wait_seconds": 60})
        )
        await allow_late(world)
        assert answer(await calling)["goal"]["status"] == "succeeded"


def test_a_goal_whose_end_is_waited_for(world: World) -> None:
    answer = world.hub.http.post(
        f"/sites/berlin/actions{ACTION}/goals", json={"order": 6}, headers={"Prefer": "wait=60"}
    )
    assert (answer.status_code, answer.json()["status"]) == (200, "succeeded")

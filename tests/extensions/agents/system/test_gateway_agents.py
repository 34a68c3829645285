"""`/mcp`: agents with the official client, over real HTTP, at a real gateway with a simulated and a real robot."""

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import httpx2
import pytest
from mcp_types import ElicitRequestFormParams, ElicitResult

from tests.support.access import Site, bearer
from tests.support.agents import agent, answer, refusal
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = [needs("simulator"), pytest.mark.ros]

REAL, SIMULATED = "/real/fibonacci", "/fibonacci"
ROUTE = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}


class World(NamedTuple):
    """A gateway, the action of a simulated robot and of one that is not, and tokens."""

    gateway: RunningGateway
    agent: str
    operator: str
    admin: str


@pytest.fixture(scope="module")
def world(shared_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    site = Site(Path(tmp_path_factory.mktemp("site")))
    tokens = [site.token(name, role) for name, role in (("bot", "agent"), ("ada", "operator"), ("eve", "admin"))]
    slowly = ("-p", "step_period:=0.3")
    with (
        running_program(shared_domain, "dock_simulator"),
        running_program(shared_domain, "fibonacci_action_server", *slowly),
        running_program(shared_domain, "fibonacci_action_server", "-r", "__ns:=/real", *slowly),
        site.gateway(shared_domain, mcp="true", approval_by_client="true") as gateway,
    ):
        headers = bearer(tokens[0])

        def ready() -> bool:
            found = [gateway.http.get(f"/actions{name}", headers=headers) for name in (REAL, SIMULATED)]
            simulated = gateway.http.get("/simulator", headers=headers)
            return simulated.is_success and all(each.is_success and each.json()["answering"] for each in found)

        wait_until(ready, "the actions and the simulator")
        yield World(gateway, *tokens)


@needs("audit_log")
async def test_an_agent_finds_its_way_and_sends_a_goal(world: World) -> None:
    async with agent(world.gateway, world.agent) as client:
        tools = {tool.name: tool for tool in (await client.list_tools()).tools}
        assert tools["list_robots"].annotations.read_only_hint
        assert tools["send_goal"].annotations.destructive_hint
        assert not any("release" in name for name in tools)

        robots = answer(await client.call_tool("list_robots", {}))["robots"]
        assert [(robot["name"], robot["simulated"]) for robot in robots] == [("/", True)]
        actions = answer(await client.call_tool("list_actions", {}))["actions"]
        assert {REAL, SIMULATED} <= {action["action_name"] for action in actions}
        messages = answer(await client.call_tool("describe_action", {"action": SIMULATED}))
        assert messages["goal"]["properties"]["order"]["type"] == "integer"

        lines: list[str] = []

        async def note(_: float, __: float | None, line: str | None) -> None:
            lines.append(line or "")

        arguments = {"action": SIMULATED, "goal": {"order": 5}}
        goal = answer(await client.call_tool("send_goal", arguments, progress_callback=note))["goal"]
        assert (goal["status"], goal["ended"]) == ("succeeded", True)
        assert goal["result"] == {"sequence": [0, 1, 1, 2, 3, 5]}
        assert any("partial_sequence" in line for line in lines)
        listed = answer(await client.call_tool("list_goals", {"action": SIMULATED, "status": "succeeded"}))["goals"]
        assert goal["goal_id"] in [each["goal_id"] for each in listed]
        answer(await client.call_tool("list_alerts", {}))

    def entries() -> list[dict]:
        url = f"/audit?what=send_goal&goal_id={goal['goal_id']}"
        found: list[dict] = world.gateway.http.get(url, headers=bearer(world.admin)).json()["records"]
        return found

    (entry,) = wait_until(entries, "the audit log")
    said = [entry[name] for name in ("principal", "role", "subject", "action_name", "outcome")]
    assert said == ["bot", "agent", "test-agent 1.0", SIMULATED, "done"]


@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_it_cancels_and_stops_and_releases_nothing(world: World, mode: str) -> None:
    arguments = {"action": SIMULATED, "goal": {"order": 40}, "wait_seconds": 0}
    async with agent(world.gateway, world.agent, mode=mode) as client:
        goal = answer(await client.call_tool("send_goal", arguments))["goal"]
        assert not goal["ended"]
        answer(await client.call_tool("cancel_goal", {"goal_id": goal["goal_id"]}))
        ended = answer(await client.call_tool("wait_for_goal", {"goal_id": goal["goal_id"]}))["goal"]
        assert ended["status"] == "canceled"
        told = answer(await client.call_tool("explain_goal", {"goal_id": goal["goal_id"]}))
        assert told["explanation"].startswith("The goal was canceled.")

        goal = answer(await client.call_tool("send_goal", arguments))["goal"]
        report = answer(await client.call_tool("stop_robots", {}))
        assert report["stop"]["latched"]
        assert report["stop"]["by"] == "bot"
        assert "stop_latched" in refusal(await client.call_tool("send_goal", arguments))
    http = world.gateway.http
    assert http.delete("/stop", headers=bearer(world.agent)).json()["code"] == "role_required"
    assert http.delete("/stop", headers=bearer(world.admin)).is_success


async def test_a_client_that_vanishes_leaves_its_goal(world: World) -> None:
    started = asyncio.Event()

    async def note(*_: object) -> None:
        started.set()

    async def call() -> None:
        async with agent(world.gateway, world.agent) as client:
            arguments = {"action": SIMULATED, "goal": {"order": 8}}
            await client.call_tool("send_goal", arguments, progress_callback=note)

    task = asyncio.create_task(call())
    await started.wait()
    task.cancel()
    await asyncio.wait({task})
    headers = bearer(world.agent)
    goal = world.gateway.http.get(f"/goals?action={SIMULATED}", headers=headers).json()["goals"][0]

    def ended() -> bool:
        status: str = world.gateway.http.get(f"/goals/{goal['goal_id']}", headers=headers).json()["status"]
        return status == "succeeded"

    wait_until(ended, "the goal")


def waiting(world: World) -> dict:
    """The goal that waits for a person."""

    def found() -> dict | None:
        approvals = world.gateway.http.get("/approvals", headers=bearer(world.operator)).json()["approvals"]
        return approvals[0] if approvals else None

    return wait_until(found, "an approval")


async def test_a_goal_to_a_real_robot_waits_for_a_person(world: World) -> None:
    http, operator = world.gateway.http, bearer(world.operator)
    arguments = {"action": REAL, "goal": {"order": 3}}

    async def decide(allow: bool) -> dict:
        approval = await asyncio.to_thread(waiting, world)
        url = f"/approvals/{approval['id']}/decision"
        assert http.put(url, json={"allow": True}, headers=bearer(world.agent)).json()["code"] == "role_required"
        assert http.put(url, json={"allow": allow}, headers=operator).is_success
        return approval

    async with agent(world.gateway, world.admin) as client:  # even with the token of an admin, it is an agent
        calling = asyncio.create_task(client.call_tool("send_goal", arguments))
        approval = await decide(allow=False)
        assert (approval["agent"], approval["client"]) == ("eve", "test-agent 1.0")
        assert (approval["action_name"], approval["goal"]) == (REAL, {"order": 3})
        assert "ada has refused the goal (approval_refused)" in refusal(await calling)
        again = http.put(f"/approvals/{approval['id']}/decision", json={"allow": True}, headers=operator)
        assert again.json()["code"] == "approval_not_found"

        calling = asyncio.create_task(client.call_tool("send_goal", arguments))
        await decide(allow=True)
        assert answer(await calling)["goal"]["status"] == "succeeded"

        calling = asyncio.create_task(client.call_tool("send_goal", arguments))
        await asyncio.to_thread(waiting, world)
        assert http.post("/stop?robot=/", json={"latch": False}, headers=operator).is_success
        assert "(stopped)" in refusal(await calling)


@needs("audit_log")
async def test_the_person_who_uses_the_agent_is_asked_in_its_program(world: World) -> None:
    """Where the settings say that their answer counts. Who is on the dashboard may refuse all the same."""
    http, operator = world.gateway.http, bearer(world.operator)
    arguments = {"action": REAL, "goal": {"order": 2}}
    asked: list[str] = []

    async def person(_: object, params: ElicitRequestFormParams) -> ElicitResult:
        asked.append(params.message)
        if len(asked) < 3:
            return ElicitResult(action="accept", content={"allow": len(asked) == 1})
        approval = await asyncio.to_thread(waiting, world)
        http.put(f"/approvals/{approval['id']}/decision", json={"allow": False}, headers=operator)
        return ElicitResult(action="accept", content={"allow": True})

    async with agent(world.gateway, world.agent, elicitation_callback=person) as client:
        assert answer(await client.call_tool("send_goal", arguments))["goal"]["status"] == "succeeded"
        assert asked == [f"bot wants to send a goal to {REAL}. Check that the area is clear."]
        assert "the user of bot has refused" in refusal(await client.call_tool("send_goal", arguments))
        assert "ada has refused" in refusal(await client.call_tool("send_goal", arguments))
        for state in ("no such", asked[0]):
            again = await client.session.call_tool("send_goal", arguments, request_state=state)
            assert "approval_not_found" in refusal(again)

    late = "approval_not_found"
    expected = [("allowed", late), ("refused", None), ("allowed", None)]

    def recorded() -> bool:
        records = http.get("/audit?what=answer_approval", headers=bearer(world.admin)).json()["records"]
        assert {(each["principal"], each["action_name"]) for each in records} <= {("bot", REAL)}
        return [(each["subject"].removesuffix(" in test-agent 1.0"), each["code"]) for each in records] == expected

    wait_until(recorded, "the audit log")


async def test_so_does_one_by_rest_with_the_token_of_an_agent(world: World) -> None:
    http = world.gateway.http
    url, agents = f"/actions{REAL}/goals", bearer(world.agent)
    calling = asyncio.create_task(asyncio.to_thread(http.post, url, json={"order": 1}, headers=agents, timeout=60))
    approval = await asyncio.to_thread(waiting, world)
    assert (approval["agent"], approval["client"]) == ("bot", None)
    with world.gateway.stream("?include=fleet", headers=bearer(world.operator)) as stream:
        assert stream.until_type("snapshot")["approvals"][0]["id"] == approval["id"]
        decided = http.put(
            f"/approvals/{approval['id']}/decision", json={"allow": True}, headers=bearer(world.operator)
        )
        assert decided.is_success
        assert stream.until_type("approvals")["approvals"] == []
    assert (await calling).status_code == 202


async def test_a_goal_is_followed_where_no_robot_is_without_a_namespace(world: World, shared_domain: int) -> None:
    with running_gateway(shared_domain, mcp="true", namespace="/robot1", max_robots="1") as gateway:
        wait_until(lambda: gateway.http.get(f"/actions{SIMULATED}").is_success, "the action")
        sent = gateway.http.post(f"/actions{SIMULATED}/goals", json={"order": 3}).json()
        async with agent(gateway) as client:
            goal = answer(await client.call_tool("wait_for_goal", {"goal_id": sent["goal_id"]}))["goal"]
        assert goal["status"] == "succeeded"


def message(method: str = "tools/call", **params: object) -> dict:
    return {"jsonrpc": "2.0", "id": 1, "method": method, "params": params}


def test_bad_input_gets_an_error_and_harms_nobody(world: World) -> None:
    headers = {**bearer(world.agent), **ROUTE}
    with httpx2.Client(base_url=world.gateway.url) as http:  # the answers are not in the OpenAPI document
        call = message(name="list_robots", arguments={})
        assert http.post("/mcp", json=call, headers=ROUTE).status_code == 401
        assert http.post("/mcp", json=call, headers={**headers, "Origin": "http://evil.example"}).status_code == 403
        assert http.post("/mcp", json=call, headers={**headers, "Host": "evil.example"}).status_code == 403
        assert http.get("/mcp", headers=headers).status_code == 405
        assert http.post("/mcp", content=b"x" * 1_000_001, headers=headers).status_code == 413
        for body in (b"{", b"[" * 100_000, b'{"a":' * 50_000, b"[]", b"null", b"\xff", b""):
            answered = http.post("/mcp", content=body, headers=headers)
            assert 400 <= answered.status_code < 500, (body[:10], answered.status_code, answered.text)
        assert "error" in http.post("/mcp", json=message(method="no/such"), headers=headers).text
        assert "there is no tool" in http.post("/mcp", json=message(name="no_such"), headers=headers).text
        deep: dict = {}
        for _ in range(40):
            deep = {"a": deep}
        for arguments, expected in (
            ({"robot": 5}, "invalid_field"),
            ({"no": 5}, "invalid_field"),
            ({"robot": deep}, "invalid_field"),
            ({"robot": "/none"}, "isError"),
        ):
            answered = http.post("/mcp", json=message(name="dock_robot", arguments=arguments), headers=headers)
            assert expected in answered.text, answered.text
        assert http.post("/mcp", json=call, headers=headers).is_success


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity"])
def test_a_number_that_is_none_is_refused_with_what_to_send(world: World, number: str) -> None:
    content = (
        '{"jsonrpc": "2.0", "id": 1, "method": "tools/call",'
        f' "params": {{"name": "list_robots", "arguments": {{"a": {number}}}}}}}'
    )
    answered = httpx2.post(f"{world.gateway.url}/mcp", content=content, headers=ROUTE | bearer(world.agent))
    assert (answered.status_code, answered.json()["error"]["code"]) == (400, -32700)
    assert "send null instead of NaN; infinite numbers are not accepted" in answered.json()["error"]["message"]

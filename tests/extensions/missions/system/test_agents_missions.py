"""Missions of agents at a real gateway: a person sees all of one to a real robot before it begins."""

import pytest

from tests.support.access import Site, bearer
from tests.support.agents import agent, answer, refusal
from tests.support.gateway import CHARGING, LOW, ready_gateway, running_dock_server
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = [needs("agents"), pytest.mark.ros]

STEPS = [{"dock": {}}, {"wait": {"seconds": 0}}]


async def test_an_agents_mission_begins_when_a_person_continues_it(domain: int) -> None:
    with ready_gateway(domain, mcp="true") as gateway:
        gateway.publish(LOW)
        async with agent(gateway) as client:
            tools = {tool.name: tool for tool in (await client.list_tools()).tools}
            assert tools["create_mission"].annotations.destructive_hint
            assert tools["get_mission"].annotations.read_only_hint
            assert not any("continue" in name or "skip" in name for name in tools)

            wrong = await client.call_tool("create_mission", {"steps": [{"dock": {}}, {"wait": {"seconds": -1}}]})
            assert "steps.1.wait.seconds" in refusal(wrong)
            arguments = {"steps": STEPS, "name": "Night", "idempotency_key": "a"}
            made = answer(await client.call_tool("create_mission", arguments))["mission"]
            assert (made["status"], made["held_for"], made["name"]) == ("held", "approval", "Night")
            again = answer(await client.call_tool("create_mission", arguments))["mission"]
            assert again["mission_id"] == made["mission_id"]
            kinds = lambda: [each["kind"] for each in gateway.http.get("/alerts").json()["alerts"]]  # noqa: E731
            wait_until(lambda: "mission_unapproved" in kinds(), "the alert")
            assert gateway.http.get("/goals").json()["goals"] == []

            gateway.http.post(f"/missions/{made['mission_id']}/continue").raise_for_status()
            wait_until(lambda: gateway.http.get("/goals").json()["goals"], "the goal")
            gateway.publish(CHARGING)
            of_mission = {"mission_id": made["mission_id"]}
            path = f"/missions/{made['mission_id']}"
            wait_until(lambda: gateway.http.get(path).json()["status"] == "succeeded", "the end")
            assert answer(await client.call_tool("get_mission", of_mission))["mission"]["status"] == "succeeded"
            assert "mission_ended" in refusal(await client.call_tool("cancel_mission", of_mission))

            later = answer(await client.call_tool("create_mission", {"steps": STEPS}))["mission"]
            listed = answer(await client.call_tool("list_missions", {"status": "held"}))["missions"]
            assert [each["mission_id"] for each in listed] == [later["mission_id"]]
            ended = answer(await client.call_tool("cancel_mission", {"mission_id": later["mission_id"]}))["mission"]
            assert ended["status"] == "canceled"


def test_so_does_one_by_rest_with_the_token_of_an_agent(domain: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    site = Site(tmp_path_factory.mktemp("site"))
    token, operator = site.token("bot", "agent"), site.token("ada", "operator")
    with running_dock_server(domain), site.gateway(domain) as gateway:

        def post(path: str, secret: str, **fields: object) -> dict[str, object]:
            found: dict[str, object] = gateway.http.post(path, json=fields or None, headers=bearer(secret)).json()
            return found

        made = post("/missions", token, steps=STEPS)
        assert (made["held_for"], made["created_by"]) == ("approval", "bot")
        path = f"/missions/{made['mission_id']}"
        for verb in ("continue", "skip"):
            assert post(f"{path}/{verb}", token)["code"] == "role_required"
        assert post(f"{path}/continue", operator)["held_for"] is None
        assert post(f"{path}/cancel", token)["status"] in ("canceling", "canceled")
        assert post("/missions", operator, steps=STEPS)["held_for"] is None

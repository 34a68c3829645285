"""Shared docks of a real gateway, by its commands and by the tool of agents."""

import json

import pytest

from tests.support.agents import agent, answer
from tests.support.commands import command
from tests.support.gateway import ready_gateway
from tests.support.installed import needs

pytestmark = pytest.mark.ros


def test_a_dock_by_commands(domain: int) -> None:
    with ready_gateway(domain) as gateway:

        def say(*words: str) -> tuple[int, str]:
            return command(gateway.url, "shared-dock", *words)

        assert "no shared docks" in say("list")[1]
        code, printed = say("enter", "lab", "--robot", "/robot1", "--group", "hall 1")
        assert (code, printed.strip()) == (0, "lab free: Nobody has the dock.")
        stored = gateway.http.get("/shared-docks/lab").json()["robots"]
        assert (stored["names"], stored["groups"], stored["all"]) == (["/robot1"], ["hall 1"], False)
        assert say("enter", "lab", "--waiting-place", "4", "1.5", "1.57")[0] == 0
        changed = gateway.http.get("/shared-docks/lab").json()
        assert changed["waiting_places"] == [{"frame": "map", "x": 4.0, "y": 1.5, "theta": 1.57}]
        assert changed["robots"]["names"] == ["/robot1"]
        assert "--pose" in say("file")[1]
        assert say("enter", "lab", "--pose", "1", "2.5", "0", "--type", "wall_dock")[0] == 0
        assert say("file") == (0, "docks:\n  lab:\n    type: wall_dock\n    frame: map\n    pose: [1.0, 2.5, 0.0]")
        assert say("report", "lab", "--out-of-order", "The cable is loose")[0] == 0
        assert "The cable is loose" in say("list")[1]
        assert say("report", "lab", "--in-order", "--occupied-by", "unknown")[0] == 0
        code, printed = say("list", "--json")
        assert json.loads(printed)["shared_docks"][0]["state"] == "occupied_by_unknown"
        for wrong in (("report", "lab"), ("report", "lab", "--in-order", "--out-of-order", "x")):
            code, printed = say(*wrong)
            assert (code, "--out-of-order" in printed) == (2, True)
        assert "shared_dock_not_found" in say("report", "attic", "--in-order")[1]
        assert say("remove", "lab")[0] == 0
        assert gateway.http.get("/shared-docks").json()["shared_docks"] == []


@needs("agents")
async def test_an_agent_reads_who_has_a_dock(domain: int) -> None:
    with ready_gateway(domain, mcp="true") as gateway:
        gateway.http.put("/shared-docks/lab", json={}).raise_for_status()
        async with agent(gateway) as client:
            (found,) = answer(await client.call_tool("list_shared_docks", {}))["shared_docks"]
            assert (found["dock_id"], found["state"], found["waiting"]) == ("lab", "free", [])

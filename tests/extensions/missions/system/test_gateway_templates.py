"""Templates and places of a real gateway, by its commands."""

import json

import pytest

from tests.support.commands import command
from tests.support.gateway import ready_gateway, running_program
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

COUNT = {
    "name": "Count",
    "parameters": {"order": {}, "then": {"default": {"wait": {"seconds": 0}}}},
    "steps": [{"action": {"name": "/fibonacci", "goal": {"order": "$order"}}}, "$then"],
}


def test_a_mission_of_a_template_by_a_command(domain: int) -> None:
    with ready_gateway(domain) as gateway, running_program(domain, "fibonacci_action_server"):
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        assert gateway.http.put("/mission-templates/count", json=COUNT).status_code == 201
        code, printed = command(gateway.url, "mission", "templates")
        assert code == 0
        assert "order= [then=" in printed
        code, printed = command(gateway.url, "mission", "run", "--template", "count", "order=3", "--json")
        mission = json.loads(printed)
        assert (code, mission["status"], mission["template"]) == (0, "succeeded", "count")
        assert mission["steps"][0]["action"]["goal"] == {"order": 3}
        code, printed = command(gateway.url, "mission", "run", "--template", "count", "orders=3")
        assert code == 1
        assert "arguments.orders" in printed

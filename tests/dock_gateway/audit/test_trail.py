"""What is recorded of requests, and by whom."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.audit.trail import AuditTrail, audited_command
from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.errors import Conflict, NotAllowed, NotFound
from dock_gateway.core.grant import Role
from dock_gateway.core.request import PERMIT, acts_on
from dock_gateway.http.operation import operation_of
from dock_gateway.operations.parameters import set_parameters
from dock_gateway.operations.services import call_service
from dock_gateway.operations.topics import publish
from dock_gateway.streams.socket import OPERATIONS
from tests.support.audited_site import GOAL, Site
from tests.support.permits import permit


@pytest.fixture
def site() -> Site:
    return Site(authentication=True)


def test_who_did_what_from_where(site: Site) -> None:
    """Whatever the request says of itself."""
    with site.client(Role.SUPERVISOR) as http:
        spoofs = {"X-Forwarded-For": "203.0.113.9", "Forwarded": "for=203.0.113.9", "X-Forwarded-User": "root"}
        assert http.delete("/stop?robot=robot1", headers=spoofs).status_code == 200
        entry = site.one()
        assert (entry.what, entry.principal, entry.role, entry.client) == (
            "release_stop",
            "supervisor",
            "supervisor",
            "192.0.2.7",
        )
        assert (entry.robot, entry.status, entry.code) == ("/robot1", 200, None)
        assert entry.token_id is not None
        assert site.audit.stored_first == ["release_stop"]
        http.delete("/stop")
        assert site.one().robot == "/"
        http.post("/battery", json={"by": "somebody else"})
        entry = site.one()
        assert (entry.principal, entry.code, entry.robot) == ("supervisor", "robot_not_found", "/")


def test_refusals_and_failures(site: Site) -> None:
    with site.client() as http:
        http.post("/dock?robot=/robot1")
        entry = site.one()
        assert (entry.principal, entry.role, entry.token_id) == (None, None, None)
        assert (entry.what, entry.robot, entry.status, entry.code) == ("dock", "/robot1", 401, "not_authenticated")
    with site.client(Role.VIEWER) as http:
        http.post("/actions/robot1/spin/goals", json={})
        entry = site.one()
        assert (entry.principal, entry.status, entry.code) == ("viewer", 403, "role_required")
        assert (entry.action_name, entry.robot) == ("/robot1/spin", "/robot1")
        http.delete("/stop")
        assert site.audit.stored_first == []
    site.audit.entries.clear()
    with site.client(Role.SUPERVISOR) as http:
        http.delete("/stop?robot=/busy")
        assert site.one().code == "dock_busy"
        http.delete("/stop?robto=/robot1")
        assert (entry := site.one()).code == "invalid_field"
        assert entry.outcome == "refused"
        assert http.delete("/stop?robot=/broken").status_code == 500
        entry = site.one()
        assert site.audit.stored_first == []
        assert (entry.status, entry.code, entry.outcome) == (500, "internal_error", "failed")


def test_goals_and_subjects(site: Site) -> None:
    with site.client(Role.VIEWER) as http:  # refused, but it is clear what it is about
        http.post(f"/goals/{GOAL.replace('-', '').upper()}/cancel")
        entry = site.one()
        assert (entry.goal_id, entry.action_name, entry.robot) == (GOAL, "/robot7/dock", "/robot7")
        http.post("/goals/nonsense/cancel")
        assert site.one().goal_id == "nonsense"
        http.put("/battery/publisher", json={})
        assert site.one().robot == "/"
        http.put("/users/night", json={})
        assert site.one().subject == "night"


def test_a_request_cannot_name_another_robot_than_it_is_about(site: Site) -> None:
    with site.client(Role.VIEWER) as http:
        for path in ("/goals", "/dock", "/undock", "/actions/robot7/dock/goals"):
            http.post(f"{path}/{GOAL}/cancel?robot=/robot9")
            assert site.one().robot == "/robot7"
    with site.client(Role.SUPERVISOR) as http:
        assert http.delete("/stop?robot=/robot9&robot=/robot7").status_code == 422
        assert (entry := site.one()).robot == "/robot9,/robot7"
        assert entry.outcome == "refused"
        http.delete("/stop?robot=/robot9,/robot7")
        assert site.one().robot == "/robot9?/robot7"


def test_names_that_are_no_robots_leave_room_for_those_that_are(site: Site) -> None:
    with site.client(Role.VIEWER) as http:
        http.post("/stop", params={"robot": [*(f"/none{number}_{'x' * 200}" for number in range(60)), "/robot7"]})
        assert (site.one().robot or "").split(",")[0] == "/robot7"


def test_tokens_and_logins(site: Site) -> None:
    with site.client() as http:
        http.post("/session", json={"token": "dgw_wrong"})
        entry = site.one()
        assert (entry.what, entry.principal, entry.code) == ("log_in", None, "invalid_token")
        http.post("/session", json={"token": site.secrets[Role.ADMIN]})
        entry = site.one()
        assert (entry.what, entry.principal, entry.status) == ("log_in", "admin", 200)
        created = http.post("/tokens", json={"name": "cron", "role": "viewer"}).json()
        assert (entry := site.one()).subject == "cron"
        assert created["secret"] not in repr(entry)
        http.delete(f"/tokens/{created['id']}")
        assert site.one().subject == "cron"
        http.delete("/session")
        assert (entry := site.one()).principal == "admin"
        http.delete("/session")
        assert (entry := site.one()).principal is None
        assert entry.status == 200
    assert site.audit.stored_first == ["log_in", "create_token", "revoke_token", "log_out", "log_out"]


def test_what_is_not_recorded(site: Site) -> None:
    with site.client(Role.ADMIN) as http:
        for path in ("/session", "/tokens", "/healthz", "/nowhere", "/docs"):
            http.get(path)
        http.post("/nowhere")
        assert http.put("/dock").status_code == 405
        http.options("/dock")
        http.options("/goals/export")
        assert http.post("/dock", headers={"Origin": "https://evil.example"}).status_code == 403
    assert site.audit.entries == []


def test_where_no_token_is_asked_for_everybody_is_nameless() -> None:
    site = Site()
    with site.client() as http:
        http.delete("/stop")
        assert ((entry := site.one()).principal, entry.role) == (None, "admin")
        http.post("/session", json={"token": "x"})
        assert site.one().role == "admin"


def test_a_request_that_cannot_be_recorded_is_answered(site: Site, caplog: pytest.LogCaptureFixture) -> None:
    def fail(_: AuditEntry) -> None:
        raise RuntimeError("full")

    site.audit.store = fail  # type: ignore[assignment,method-assign]
    with site.client(Role.SUPERVISOR) as http:
        assert http.delete("/stop").status_code == 200
    assert "release_stop could not be recorded" in caplog.text


async def test_a_goal_that_is_refused_is_recorded_with_the_action_that_was_picked() -> None:
    site = await asyncio.to_thread(Site)
    scope = {"type": "websocket", "client": ("192.0.2.7", 1), "state": {"parts": site.parts}, "request_id": "r1"}

    async def picks() -> None:
        PERMIT.set(permit())
        acts_on("/robot7/dock")
        raise Conflict("busy", code="dock_busy")

    async def is_not_allowed() -> None:
        raise NotAllowed("no", code="role_required")

    with pytest.raises(Conflict):
        await audited_command(scope, "send_goal", OPERATIONS["send_goal"], {}, picks)
    entry = site.one()
    assert (entry.robot, entry.action_name, entry.code) == ("/robot7", "/robot7/dock", "dock_busy")
    with pytest.raises(NotAllowed):  # the next one on the same connection
        await audited_command(scope, "send_goal", OPERATIONS["send_goal"], {}, is_not_allowed)
    entry = site.one()
    assert (entry.robot, entry.action_name, entry.code) == ("/", None, "role_required")


COMMAND = [
    ("stop", {"robot": ("/robot7",)}, {}, ("/robot7", None, None, 200, None)),
    ("stop", {"robot": ("/robto7",)}, {}, ("/", None, None, 200, None)),  # no robot is known, so all were stopped
    ("release_stop", {}, {}, ("/", None, None, 200, None)),
    ("send_goal", {}, {"goal": {"goal_id": GOAL, "action_name": "/d"}}, ("/", "/d", GOAL, 200, None)),
    ("send_goal", {"action": "spin", "robot": "r"}, NotFound("x", code="y"), ("/r", "/r/spin", None, 404, "y")),
    ("send_goal", {"action": "/a/spin", "robot": "/b"}, NotFound("x", code="y"), ("/a", "/a/spin", None, 404, "y")),
    ("cancel_goal", {"goal_id": GOAL}, Conflict("x", code="y"), ("/robot7", "/robot7/dock", GOAL, 409, "y")),
    ("cancel_goal", {"goal_id": 7}, RuntimeError("x"), ("/", None, None, 500, "internal_error")),
]


@pytest.mark.parametrize(("op", "fields", "result", "found"), COMMAND)
async def test_commands(op: str, fields: dict[str, Any], result: Any, found: tuple[Any, ...]) -> None:
    site = await asyncio.to_thread(Site)
    scope = {"type": "websocket", "client": ("192.0.2.7", 1), "state": {"parts": site.parts}, "request_id": "r1"}

    async def carry_out() -> Any:
        if isinstance(result, Exception):
            raise result
        return result

    if isinstance(result, Exception):
        with pytest.raises(type(result)):
            await audited_command(scope, op, OPERATIONS[op], fields, carry_out)
    else:
        assert await audited_command(scope, op, OPERATIONS[op], fields, carry_out) == result
    entry = site.one()
    assert (entry.robot, entry.action_name, entry.goal_id, entry.status, entry.code) == found
    assert (entry.what, entry.client, entry.request_id) == (op, "192.0.2.7", "r1")
    assert site.audit.stored_first == (["release_stop"] if op == "release_stop" else [])


@pytest.mark.parametrize(
    ("path", "operation", "field"),
    [
        ("/services/robot7/base/reset", call_service, "service"),
        ("/topics/robot7/base/chatter", publish, "topic"),
        ("/nodes/robot7/base/driver/parameters", set_parameters, "node"),
    ],
)
async def test_what_is_done_on_the_graph_is_about_the_same_at_each_door(path: str, operation: Any, field: str) -> None:
    site = await asyncio.to_thread(Site, authentication=True)
    with site.client(Role.VIEWER) as http:  # refused, but it is clear what it is about
        http.request("PATCH" if field == "node" else "POST", path, json={})
    entry = site.one()
    name = path.partition("/robot7")[1] + path.partition("/robot7")[2].removesuffix("/parameters")
    assert (entry.robot, entry.subject, entry.code) == ("/robot7/base", name, "role_required")

    answer = {"goal": "a field of the response of some service"}

    async def carry_out() -> dict[str, str]:
        return answer

    scope = {"type": "websocket", "client": ("192.0.2.7", 1), "state": {"parts": site.parts}}
    needs = operation_of(operation)
    assert await audited_command(scope, operation.__name__, needs, {field: name}, carry_out) == answer
    assert ((entry := site.one()).robot, entry.subject) == ("/robot7/base", name)
    await audited_command(scope, operation.__name__, needs, {field: name}, carry_out, subject=f"{name} speed")
    assert ((entry := site.one()).robot, entry.subject) == ("/robot7/base", f"{name} speed")


@pytest.mark.parametrize("op", ["ping", "unsubscribe", "nonsense"])
async def test_other_commands_are_not_recorded(op: str) -> None:
    async def carry_out() -> dict[str, Any]:
        return {}

    assert await audited_command({}, op, OPERATIONS.get(op), {}, carry_out) == {}


async def forever(*_: Any) -> Any:
    await asyncio.Event().wait()


@pytest.mark.parametrize("command", [False, True])
async def test_what_the_end_of_the_gateway_cuts_off_is_recorded(command: bool) -> None:
    site = await asyncio.to_thread(Site)
    route = SimpleNamespace(name="calibrate_dock", endpoint=forever, query_names=[])
    scope: dict[str, Any] = {
        "type": "http",
        "method": "POST",
        "path": "/calibration",
        "query_string": b"",
        "headers": [],
        "route": route,
        "client": ("192.0.2.7", 1),
        "state": {"parts": site.parts},
    }
    async with asyncio.TaskGroup() as tasks:
        cut_off = tasks.create_task(
            audited_command(
                scope | {"type": "websocket"}, "publish_battery", OPERATIONS["publish_battery"], {}, forever
            )
            if command
            else AuditTrail(forever)(scope, forever, forever)
        )
        await asyncio.sleep(0)
        cut_off.cancel()
    entry = site.one()
    assert entry.what == ("publish_battery" if command else "calibrate_dock")
    assert (entry.status, entry.code, entry.outcome) == (503, "shutting_down", "failed")

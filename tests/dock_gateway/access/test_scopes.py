"""A limited grant: every route and every command about another robot is refused, whatever the role."""

import asyncio
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest
from starlette.testclient import TestClient

from dock_gateway.access.carry_out import carry_out
from dock_gateway.access.logins import Logins
from dock_gateway.access.scopes import require_covered
from dock_gateway.app import create_app
from dock_gateway.core.access import ANYBODY
from dock_gateway.core.alerts import Alerts
from dock_gateway.core.errors import MalformedRequest, NotAllowed, NotFound, ServedElsewhere
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.share import Share
from dock_gateway.doors.rest import stop_routes
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.operation import Scope, operation_of
from dock_gateway.http.parts import Parts
from dock_gateway.robots.robots import Robots
from dock_gateway.settings import Settings
from dock_gateway.streams.commands import COMMANDS
from dock_gateway.streams.socket import OPERATIONS
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory
from tests.support.parts import Refusing
from tests.support.robot_actions import make_robot_actions
from tests.support.routes import REQUESTS, path_of

SETTINGS = Settings(authentication=True, database_url="sqlite:////nowhere")
GOAL, UNKNOWN = "00000000-0000-4000-8000-000000000000", "00000000-0000-4000-8000-000000000001"
ALERT = "x1"
APPROVAL = "a1"


async def _goal(goal_id: str, grant: Grant) -> Any:
    if goal_id != GOAL or not grant.covers_action(action := "/robot2/connect_to_charging_dock"):
        raise NotFound(f"there is no goal {goal_id}", code="goal_not_found")
    return SimpleNamespace(action_name=action)


def _approval(approval_id: str, grant: Grant) -> str:
    if approval_id != APPROVAL or not grant.covers_action("/robot2/dock"):
        raise NotFound("it does not wait", code="approval_not_found")
    return approval_id


def _alert(alert_id: str, grant: Grant) -> Any:
    if alert_id != ALERT or not grant.covers_alert("/robot2"):
        raise NotFound(f"there is no alert {alert_id}", code="alert_not_found")
    return SimpleNamespace(robot="/robot2")


class Other(Refusing):
    """A gateway with a robot `/robot2`, a goal and an alert of it. What else it is asked for shows a gap."""

    def __init__(self, default_namespace: str = "/robot2") -> None:
        self.logins = Logins(HistoryInMemory())
        super().__init__(
            {
                **audit_parts(),
                Settings: SETTINGS,
                Logins: self.logins,
                RobotActions: make_robot_actions(),
                Robots: SimpleNamespace(default_namespace=default_namespace),
                Alerts: SimpleNamespace(get=_alert),
                Approvals: SimpleNamespace(get=_approval),
                Goals: SimpleNamespace(get=_goal),
            }
        )


@pytest.fixture
def parts() -> Other:
    return Other()


def refused(parts: Parts, grant: Grant, scope: Scope, names: dict[str, Any]) -> bool:
    try:
        asyncio.run(require_covered(parts, grant, scope, names, "it"))
    except NotAllowed as error:
        return error.code == "not_allowed"
    return False


@pytest.mark.parametrize("limits", [{"robots": ("/robot1",)}, {"actions": ("/robot1/*",)}])
def test_every_route_about_another_robot_is_refused(limits: dict[str, tuple[str, ...]]) -> None:
    parts = Other()
    grant = Grant(Role.SUPERVISOR, **limits)
    _, secret = asyncio.run(parts.logins.create_token("limited", grant))
    app = create_app(SETTINGS, parts)
    with TestClient(app, "http://127.0.0.1:8000", raise_server_exceptions=False) as client:
        client.headers["Authorization"] = f"Bearer {secret}"
        for method, template, operation in REQUESTS:
            scope, what = operation.scope, (method, template)
            if operation.role in (None, Role.ADMIN) or scope in (Scope.ANY, Scope.LISTED):
                continue
            if scope in (Scope.ROBOT, Scope.ROBOTS, Scope.ALERT, Scope.TOPIC, Scope.LOOKED_AT) and "actions" in limits:
                continue  # they are about a robot, not about one of its actions
            answer = client.request(method, path_of(template))
            if scope is Scope.GOAL and "{name" not in template:
                unknown = client.request(method, path_of(template).replace(GOAL, UNKNOWN))
                assert (answer.status_code, answer.json()["code"]) == (404, "goal_not_found"), what
                assert answer.text.replace(GOAL, UNKNOWN) == unknown.text, what
            elif scope is Scope.APPROVAL:
                assert (answer.status_code, answer.json()["code"]) == (404, "approval_not_found"), what
            elif scope is Scope.ALERT:
                assert (answer.status_code, answer.json()["code"]) == (404, "alert_not_found"), what
            else:
                assert answer.json()["code"] == "not_allowed", what


ROBOT1 = Grant(Role.SUPERVISOR, robots=("/robot1",))
NAMES: dict[Scope, dict[str, Any]] = {
    Scope.ROBOT: {"robot": "/robot1"},
    Scope.ROBOTS: {"robot": "/robot1/arm"},
    Scope.DOCK: {"robot": "/robot1"},
    Scope.UNDOCK: {"robot": "/robot1/"},
    Scope.ACTION: {"name": "robot1/fibonacci"},
    Scope.NEW_GOAL: {"action": "fibonacci", "robot": "/robot1"},
    Scope.TOPIC: {"topic": "/robot1/odom"},
    Scope.LOOKED_AT: {"node": "robot1/base"},
    Scope.SERVICE: {"service": "robot1/reset"},
    Scope.NODE: {"node": "/robot1/base"},
    Scope.PUBLISHING: {"topic": "robot1/odom"},
}
OTHERS: dict[Scope, list[dict[str, Any]]] = {
    Scope.ROBOT: [{}, {"robot": "/robot2"}, {"robot": "/"}, {"robot": "/robot10"}],
    Scope.ROBOTS: [{}, {"robot": "/robot2"}, {"robot": "/"}, {"robot": "/robot10"}],
    Scope.DOCK: [{}, {"robot": "/robot2"}],
    Scope.UNDOCK: [{}, {"robot": "/robot2"}],
    Scope.ACTION: [{"name": "robot2/fibonacci"}, {"name": "robot1"}, {"name": "fibonacci"}],
    Scope.NEW_GOAL: [
        {},
        {"robot": "/robot2"},
        {"action": "fibonacci"},
        {"action": "/robot2/fibonacci", "robot": "/robot1"},
        {"action": "/robot1/fibonacci", "robot": "/robot2"},
        {"action": "robot2/fibonacci"},
    ],
    Scope.TOPIC: [{"topic": "/robot2/odom"}, {"topic": "odom"}, {}, {"name": "rosout"}],
    Scope.LOOKED_AT: [{"node": "robot2/base"}, {"service": "robot10/reset"}, {"service": "reset"}, {}],
    Scope.SERVICE: [{"service": "robot2/reset"}, {"service": "/reset"}, {}],
    Scope.NODE: [{"node": "robot2/base"}, {"node": "base"}, {}],
    Scope.PUBLISHING: [{"topic": "/robot2/odom"}, {"topic": "odom"}, {}],
    Scope.GOAL: [{"goal_id": GOAL, "name": "robot2/fibonacci"}],
    Scope.EVERY: [{}, {"robot": "/robot1"}],
}


@pytest.mark.parametrize("scope", list(NAMES))
def test_what_is_about_the_own_robot_is_allowed(parts: Parts, scope: Scope) -> None:
    assert not refused(parts, ROBOT1, scope, NAMES[scope])


@pytest.mark.parametrize(("scope", "names"), [(scope, names) for scope, many in OTHERS.items() for names in many])
def test_what_is_about_another_one_is_not(parts: Parts, scope: Scope, names: dict[str, Any]) -> None:
    assert refused(parts, ROBOT1, scope, names)


@pytest.mark.parametrize(
    ("scope", "name", "ids"),
    [
        (Scope.GOAL, "goal_id", (GOAL, UNKNOWN)),
        (Scope.ALERT, "alert_id", (ALERT, "low_battery:/x")),
        (Scope.APPROVAL, "approval_id", (APPROVAL, UNKNOWN)),
    ],
)
def test_what_is_another_s_is_as_unknown_as_what_there_is_not(
    parts: Parts, scope: Scope, name: str, ids: tuple[str, str]
) -> None:
    problems = []
    for each in ids:
        with pytest.raises(NotFound) as error:
            asyncio.run(require_covered(parts, ROBOT1, scope, {name: each}, "it"))
        problems.append(str(error.value.problem()).replace(each, "ID"))
    assert problems[0] == problems[1]


@pytest.mark.parametrize("scope", list(Scope))
def test_without_limits_everything_is_allowed(parts: Parts, scope: Scope) -> None:
    assert not refused(parts, Grant(Role.VIEWER), scope, {"topic": "/x"})


@pytest.mark.parametrize("scope", [Scope.SERVICE, Scope.NODE, Scope.PUBLISHING])
def test_who_is_limited_to_some_actions_gets_around_them_by_no_service_topic_or_parameter(
    parts: Parts, scope: Scope
) -> None:
    assert refused(parts, Grant(Role.SUPERVISOR, actions=("/robot1/dock",)), scope, NAMES[scope])


@pytest.mark.parametrize("robots", [("/",), ("/", "/*"), ("**",)])
async def test_who_is_limited_to_some_robots_cannot_release_the_stop_of_all(robots: tuple[str, ...]) -> None:
    parts = Other(default_namespace="/")
    for scope in (operation_of(stop_routes.release_stop).scope, OPERATIONS["release_stop"].scope):
        for names in ({}, {"robot": "/"}):
            with pytest.raises(NotAllowed, match="every robot"):
                await require_covered(parts, Grant(Role.SUPERVISOR, robots), scope, names, "release_stop")
            for grant in (Grant(Role.SUPERVISOR), Grant(Role.SUPERVISOR, actions=("*/undock",))):
                await require_covered(parts, grant, scope, names, "release_stop")


def test_a_list_of_topics_alone_limits_nothing_else(parts: Parts) -> None:
    grant = Grant(Role.OPERATOR, topics=("*/battery_status",))
    assert not refused(parts, grant, Scope.ROBOT, {"robot": "/robot2"})
    assert not refused(parts, grant, Scope.TOPIC, {"topic": "/robot2/battery_status"})
    assert refused(parts, grant, Scope.TOPIC, {"topic": "/robot2/odom"})


def test_every_scope_is_used_and_known() -> None:
    used = {operation.scope for operation in (*(each for *_, each in REQUESTS), *OPERATIONS.values())}
    assert used == set(Scope)
    assert used - NAMES.keys() - OTHERS.keys() == {Scope.ANY, Scope.LISTED, Scope.ALERT, Scope.APPROVAL}


@pytest.mark.parametrize(
    ("scope", "names", "elsewhere"),
    [
        (Scope.ROBOT, {"robot": "/robot2"}, True),
        (Scope.ROBOT, {"robot": "/robot1"}, False),
        (Scope.ROBOT, {}, True),  # the configured one
        (Scope.ROBOTS, {"robot": "/robot2"}, True),
        (Scope.ROBOTS, {"robot": "/"}, False),
        (Scope.DOCK, {"robot": "/robot2"}, True),
        (Scope.UNDOCK, {"robot": "/robot2"}, True),
        (Scope.ACTION, {"name": "robot2/spin"}, True),
        (Scope.ACTION, {"name": "robot1/spin"}, False),
        (Scope.GOAL, {"goal_id": GOAL}, True),
        (Scope.NEW_GOAL, {"robot": "/robot2"}, True),
        (Scope.NEW_GOAL, {"robot": "/robot2", "action": "spin"}, True),
        (Scope.NEW_GOAL, {"robot": "/robot1", "action": "spin"}, False),
        (Scope.NEW_GOAL, {"robot": "/robot1", "action": "/robot2/spin"}, True),
        (Scope.NEW_GOAL, {"action": "/elsewhere/dock1"}, False),
        (Scope.SERVICE, {"service": "/robot2/set"}, True),
        (Scope.NODE, {"node": "/robot2/controller"}, True),
        (Scope.PUBLISHING, {"topic": "/robot2/cmd_vel"}, True),
        (Scope.PUBLISHING, {"topic": "/cmd_vel"}, True),
        (Scope.PUBLISHING, {"topic": "/robot1/cmd_vel"}, False),
        (Scope.TOPIC, {"topic": "/robot2/odom"}, False),
        (Scope.LOOKED_AT, {"node": "/robot2/controller"}, False),
        (Scope.EVERY, {}, False),
        (Scope.LISTED, {}, False),
        (Scope.ANY, {}, False),
    ],
)
async def test_what_would_act_on_a_robot_of_another_gateway_is_refused(
    parts: Other, scope: Scope, names: dict[str, Any], *, elsewhere: bool
) -> None:
    share = parts.add(Share, Share(["/robot1"], {"/elsewhere/dock1": "/robot1"}))
    with pytest.raises(ServedElsewhere) if elsewhere else nullcontext():
        await require_covered(parts, share.narrow(Grant(Role.SUPERVISOR)), scope, names, "it")


async def test_who_may_not_see_a_robot_does_not_learn_who_serves_it(parts: Other) -> None:
    share = parts.add(Share, Share(["/robot1"]))
    with pytest.raises(NotFound):
        await require_covered(parts, share.narrow(ROBOT1), Scope.GOAL, {"goal_id": GOAL}, "it")
    with pytest.raises(NotAllowed):
        await require_covered(parts, share.narrow(ROBOT1), Scope.DOCK, {"robot": "/robot2"}, "it")


async def test_a_release_that_cannot_be_read_releases_nothing(parts: Other) -> None:
    with pytest.raises(MalformedRequest):
        await carry_out(parts, ANYBODY, COMMANDS["release_stop"], MalformedRequest("not JSON"), {"type": "websocket"})

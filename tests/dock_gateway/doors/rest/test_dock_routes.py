"""`/dock` and `/undock`: the action that is used, and the goals that are listed, lie within the user's limits."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest
from starlette.testclient import TestClient

from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.errors import NotAllowed
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Verb
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.action import Action
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import Robots
from dock_gateway.settings import Settings
from dock_gateway.streams.commands import COMMANDS
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory
from tests.support.robot_actions import make_robot_actions

SETTINGS = Settings(authentication=True, database_url="sqlite:////nowhere")
OURS = Grant(Role.OPERATOR, actions=("*/connect_to_charging_dock", "*/disconnect_from_charging_dock"))


class LateActions(ActionRegistry):
    """Finds nav2's action of a robot, which was not there when the request was authorized."""

    def __init__(self, robots: Any, robot_actions: RobotActions) -> None:
        fanout, bridge = Fanout(queue_limit=10), cast("Any", None)
        super().__init__(
            SETTINGS,
            bridge,
            fanout,
            HistoryInMemory(),
            PendingFacts(0.05),
            interlock=Interlock(fanout, LatchFile(SETTINGS.stop_file)),
            robots=robots,
            robot_actions=robot_actions,
        )
        self._known = robot_actions

    async def find_docking(self, verb: Verb, robot: str | None = None, grant: Grant = UNLIMITED) -> Action:
        name = f"{robot}/{verb}_robot"
        kind = f"nav2_msgs/action/{verb.capitalize()}Robot"
        action: Any = SimpleNamespace(name=name, type=kind, verb=verb, family="nav2", on_graph=True, busy=False)
        self._known.add(action)
        self._actions[name] = action
        return await super().find_docking(verb, robot, grant)


class LateServer(Parts):
    """A gateway that has seen no docking server of a robot when a request arrives, and nav2's right afterwards."""

    def __init__(self) -> None:
        self.logins = Logins(HistoryInMemory())
        robot_actions = make_robot_actions(SETTINGS)
        robots: Any = SimpleNamespace(default_namespace="/", get=lambda name: SimpleNamespace(namespace=name))
        actions = LateActions(robots, robot_actions)
        super().__init__(
            {
                **audit_parts(),
                Settings: SETTINGS,
                Logins: self.logins,
                Quotas: Quotas(SETTINGS),
                ActionRegistry: actions,
                Robots: robots,
                RobotRegistry: robots,
                RobotActions: robot_actions,
                DockingHints: DockingHints(SETTINGS, actions, robots),
            }
        )


@pytest.fixture
def parts() -> LateServer:
    return LateServer()


@pytest.fixture
def client(parts: LateServer) -> TestClient:
    _, secret = asyncio.run(parts.logins.create_token("limited", OURS))
    app = create_app(SETTINGS, parts)
    headers = {"Authorization": f"Bearer {secret}"}
    return TestClient(app, "http://127.0.0.1:8000", raise_server_exceptions=False, headers=headers)


@pytest.mark.parametrize("path", ["/dock", "/undock"])
def test_no_goal_is_sent_to_an_action_beyond_the_limits(client: TestClient, path: str) -> None:
    with client:
        answer = client.post(path, params={"robot": "/robot1"})
    assert (answer.status_code, answer.json()["code"]) == (403, "not_allowed")
    assert f"/robot1{path}_robot" in answer.json()["detail"]


async def test_no_goal_is_sent_to_such_an_action_on_a_websocket(parts: LateServer) -> None:
    principal = Principal("limited", PrincipalKind.TOKEN, OURS, "id")
    with pytest.raises(NotAllowed) as refused:
        await COMMANDS["send_goal"](parts, principal, {"robot": "/robot1"})
    assert refused.value.code == "not_allowed"

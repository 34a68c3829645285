"""What supervisors and load balancers read without a login names neither robots nor people."""

import asyncio
from types import SimpleNamespace

import pytest
from starlette.testclient import TestClient

from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.core.grant import Grant, Role
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.hints import Sight, docking_hint
from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.registry import ActionRegistry, DockingServerStates
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History, HistoryStats
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory
from tests.support.shapes import check_answer

STOP = {"latched": True, "stopped_at": "2026-11-21T03:32:40Z", "by": "ada", "robots": ["/robot1"], "persisted": True}
SERVER = ServerState("/dock", "pkg/action/Dock", available=False, answering=False)
SIGHTS = [Sight("/"), Sight("/robot1", battery="/robot1/battery_status"), Sight("/docking", dock="/docking/dock")]
LINE = 'robots."/robot1".dock_action = "/docking/dock"'
EVERYTHING = ("ada", ["/robot1"], "no route to db.example", ["/robot1", "/docking"], [LINE], ["Two bases."])
NOBODY = (None, [], None, [], [], [])


def read(grant: Grant | None, *, authentication: bool = True) -> tuple[object, ...]:
    settings = Settings(authentication=authentication, database_url="sqlite:////nowhere")
    logins = Logins(HistoryInMemory())
    _, secret = asyncio.run(logins.create_token("one", grant or Grant(Role.VIEWER)))
    parts = Parts(
        {
            **audit_parts(),
            Settings: settings,
            Logins: logins,
            ActionRegistry: SimpleNamespace(
                servers_of=lambda _: DockingServerStates(SERVER, SERVER),
                get=lambda _: SimpleNamespace(watch=SimpleNamespace(ready=True)),
            ),
            Bridge: SimpleNamespace(alive=True),
            RobotRegistry: SimpleNamespace(find=lambda _: "/"),
            DockingHints: SimpleNamespace(sights=lambda: SIGHTS, hint=lambda name, _: docking_hint(name, SIGHTS)),
            AlertBoard: SimpleNamespace(of_graph=lambda _: [SimpleNamespace(detail="Two bases.")]),
            History: SimpleNamespace(stats=lambda: HistoryStats(last_error=EVERYTHING[2])),
            Stopper: SimpleNamespace(state=lambda _: STOP),
        }
    )
    with TestClient(create_app(settings, parts), "http://127.0.0.1:8000") as http:
        headers = {} if grant is None else {"Authorization": f"Bearer {secret}"}
        answer = http.get("/readyz", headers=headers)
        named = http.get("/readyz?robot=/robot1", headers=headers)
    assert (named.status_code == 403) is (answer.json()["robots"] == [])
    check_answer("GET", "/readyz", 200, "application/json", answer.content)
    ready = answer.json()
    assert ready["stop"]["latched"] is True
    shown = ready["stop"]["by"], ready["stop"]["robots"], ready["history"]["last_error"]
    return *shown, ready["robots"], ready["settings"], ready["problems"]


@pytest.mark.parametrize(
    ("grant", "shown"),
    [
        (None, NOBODY),
        (Grant(Role.VIEWER, robots=("/robot2",)), NOBODY),
        (Grant(Role.VIEWER), EVERYTHING),
    ],
)
def test_who_sees_names(grant: Grant | None, shown: tuple[object, ...]) -> None:
    assert read(grant) == shown


def test_without_authentication_everybody_does() -> None:
    assert read(None, authentication=False) == EVERYTHING

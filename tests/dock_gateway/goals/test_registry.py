"""Actions come and go with the graph; one whose package is missing says what to install."""

from collections.abc import Callable
from datetime import timedelta
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.errors import NotFound, NotInstalled
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals import registry as actions
from dock_gateway.goals.action_schema import ActionInfo
from dock_gateway.goals.registry import FORGET_AFTER, ActionRegistry
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.ros.graph import Scan
from dock_gateway.settings import Settings
from tests.support.history import HistoryInMemory, make_goal
from tests.support.robot_actions import make_robot_actions


class FakeBridge:
    """Runs at once what is for the ROS thread; there is no node, so only what fails before that can be tried."""

    node = None

    async def call(self, function: Callable[[], Any], **_: object) -> Any:
        return function()


@pytest.fixture
def registry() -> ActionRegistry:
    return make_registry()


def make_registry(forget_after: float = FORGET_AFTER, **names: str) -> ActionRegistry:
    fanout = Fanout(queue_limit=10)
    settings = Settings(server_wait=0.05, **names)  # type: ignore[arg-type]
    interlock = Interlock(fanout, LatchFile(settings.stop_file))
    bridge: Any = FakeBridge()
    return ActionRegistry(
        settings,
        bridge,
        fanout,
        HistoryInMemory(),
        PendingFacts(0.05),
        interlock=interlock,
        robots=cast("Any", None),
        robot_actions=make_robot_actions(settings),
        forget_after=forget_after,
    )


async def test_an_action_whose_package_is_missing(registry: ActionRegistry) -> None:
    await registry.update(Scan({"/navigate": ["slam_msgs/action/MakeMap"]}))
    (entry,) = registry.uninstalled()
    assert (entry.name, entry.type) == ("/navigate", "slam_msgs/action/MakeMap")
    assert "ros-jazzy-slam-msgs" in entry.hint
    document = ActionInfo.model_validate(entry.document())
    assert (document.installed, document.hint, document.available, document.answering) == (
        False,
        entry.hint,
        True,
        False,
    )
    with pytest.raises(NotInstalled) as refused:
        await registry.find("/navigate")
    assert refused.value.code == "interface_not_installed"
    await registry.update(Scan())
    assert registry.uninstalled() == []


async def test_an_action_that_nobody_serves(registry: ActionRegistry) -> None:
    with pytest.raises(NotFound) as refused:
        await registry.find("/nothing")
    assert refused.value.code == "action_not_found"


async def test_an_action_that_cannot_be_used_has_its_verb(registry: ActionRegistry) -> None:
    kind = "no_such_package/action/Park"
    await registry.update(Scan({"/a/connect_to_charging_dock": [kind], "/a/park": [kind]}))
    assert [entry.verb for entry in registry.uninstalled()] == ["dock", None]


async def test_types_that_no_package_can_have_do_no_harm(registry: ActionRegistry) -> None:
    await registry.update(Scan({"/a": ["nonsense"], "/b": ["os/action/path"], "/c": ["../x/action/Y"]}))
    assert [entry.name for entry in registry.uninstalled()] == ["/a", "/b", "/c"]


async def test_a_type_with_fields_that_no_msg_file_can_have(
    registry: ActionRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise TypeError("fields of type long double are not supported")

    monkeypatch.setattr(actions, "ActionKind", refuse)
    await registry.update(Scan({"/odd": ["odd_msgs/action/Odd"]}))
    assert [entry.hint for entry in registry.uninstalled()] == ["fields of type long double are not supported"]


async def test_whatever_is_wrong_with_one_action_the_others_are_tried(
    registry: ActionRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[str] = []

    class Failing:
        def __init__(self, _: object, name: str, __: object) -> None:
            tried.append(name)
            raise RuntimeError("no type support")

        def close(self) -> None:
            """Never called."""

    monkeypatch.setattr(actions, "ActionPort", Failing)
    kind = "action_tutorials_interfaces/action/Fibonacci"
    while await registry.update(Scan({"/a": [kind], "/b": [kind], "/c/connect_to_charging_dock": [kind]})):
        pass  # a busy machine takes several turns
    assert tried == ["/c/connect_to_charging_dock", "/a", "/b"], "docking comes first"
    assert {entry.hint for entry in registry.uninstalled()} == {"no type support"}


async def test_the_actions_that_robots_share_are_those_of_each_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    registry = make_registry(undock_action="/fleet/undock")
    names = ("/fleet/undock", "/fleet/dock", "/robot1/dock", "/robot2/dock")
    monkeypatch.setattr(registry, "all", lambda: [SimpleNamespace(name=name) for name in names])
    assert [action.name for action in registry.under("/robot1")] == ["/fleet/undock", "/robot1/dock"]


def test_goals_that_were_lost_long_ago_are_not_expected(registry: ActionRegistry) -> None:
    old, new, running = goals = [make_goal(number, GoalStatus.LOST, "/gone") for number in range(3)]
    old.updated_at, new.updated_at = utc_now() - timedelta(hours=2), utc_now() - timedelta(minutes=1)
    running.status = GoalStatus.EXECUTING
    registry.expect(goals)
    assert registry.lost() == [new]


async def test_who_wants_to_know_hears_of_goals_whose_action_does_not_come_back() -> None:
    registry = make_registry(forget_after=-1.0)
    lost: list[Goal] = []
    stopped: list[Goal] = []

    def stop(goal: Goal) -> str:
        stopped.append(goal)
        return "zero velocity was sent"

    registry.on_lost.append(lost.append)
    registry.before_lost.append(stop)
    registry.expect([goal := make_goal(1, GoalStatus.EXECUTING, "/gone")])
    await registry.update(Scan())
    await registry.update(Scan())
    assert (lost, stopped, goal.status) == ([goal], [goal], GoalStatus.LOST)
    assert goal.error == GoalError("action_server_lost", "the action has no server any more; zero velocity was sent")

"""Namespaces as clients may write them, whose an action is, and robots that come, go and come back."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import InvalidField, NotFound
from dock_gateway.core.namespace import normalize_namespace, read_namespace
from dock_gateway.robots import registry as module
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.graph import Presence, Scan
from dock_gateway.settings import Settings


@pytest.mark.parametrize(("text", "namespace"), [("", "/"), ("/", "/"), ("robot1", "/robot1"), ("/a/b/", "/a/b")])
def test_settings_are_generous(text: str, namespace: str) -> None:
    assert normalize_namespace(text) == namespace


@pytest.mark.parametrize(("text", "namespace"), [("/", "/"), ("/robot1", "/robot1"), ("/fleet/r_2/", "/fleet/r_2")])
def test_clients_name_a_namespace(text: str, namespace: str) -> None:
    assert read_namespace(text) == namespace


@pytest.mark.parametrize(
    "text", ["", "robot1", "/robot 1", "/1robot", "/a//b", "/a/../b", "/röbot", "/a\0", "/a" * 128]
)
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(InvalidField):
        read_namespace(text)


BATTERY = Scan(topics={"/robot1/battery_status": ["sensor_msgs/msg/BatteryState"]})
DOCK = Scan(actions={"/robot1/connect_to_charging_dock": []})


class Scene:
    """A registry whose bridge carries out everything at once; who is on the graph is `presence`."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.opened: list[str] = []
        self.closed: list[str] = []
        self.presence = Presence(frozenset(), publishes=False, base=False)
        for name in ("BatteryPort", "VelocityPort", "LatchPort"):
            monkeypatch.setattr(module, name, self._port)
        monkeypatch.setattr(module, "find_presence", lambda *_, **__: self.presence)
        parts: Any = self
        self.node = None
        self.joined: set[str] = set()
        self.robots = RobotRegistry(Settings(), parts, parts, parts, parts)

    def _port(self, _: object, topic: str, *__: object, **___: object) -> Any:
        self.opened.append(topic)
        return SimpleNamespace(close=lambda: self.closed.append(topic))

    async def call(self, function: Callable[[], Any], **_: object) -> Any:
        return function()

    def to_ros(self, function: Callable[[], Any]) -> None:
        function()

    def join(self, namespace: str, _: object) -> None:
        self.joined.add(namespace)

    def leave(self, namespace: str) -> None:
        self.joined.remove(namespace)

    def watch(self, *_: str) -> None:
        pass


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    return Scene(monkeypatch)


@pytest.mark.parametrize(
    ("action", "owner"),
    [
        ("/dock", "/"),
        ("/arm/move", "/"),
        ("/robot1/dock", "/robot1"),
        ("/robot1/arm/move", "/robot1/arm"),
        ("/robot1/legs/move", "/robot1"),
        ("/robot10/dock", "/"),
    ],
)
async def test_an_action_belongs_to_the_nearest_robot(scene: Scene, action: str, owner: str) -> None:
    for name in ("/", "/robot1", "/robot1/arm"):
        await scene.robots.open(name)
    found = scene.robots.owner(action)
    assert found is not None
    assert found.namespace == owner
    scene.robots.forget("/")
    assert (scene.robots.owner(action) is None) is (owner == "/")


async def test_a_robot_leaves_all_its_topics(scene: Scene) -> None:
    await scene.robots.update(BATTERY)
    assert scene.robots.get("/robot1").namespace == "/robot1"
    scene.robots.forget("/robot1")
    with pytest.raises(NotFound):
        scene.robots.get("/robot1")
    assert scene.closed == scene.opened == [f"/robot1/{name}" for name in ("battery_status", "cmd_vel", "stop_latched")]
    assert scene.joined == set()


async def test_a_robot_that_was_forgotten_is_back_when_it_is_there_itself(scene: Scene) -> None:
    await scene.robots.update(BATTERY)
    scene.robots.forget("/robot1")
    await scene.robots.update(BATTERY)  # another gateway is at the topic
    assert not scene.joined
    scene.presence = Presence(frozenset(), publishes=True, base=False)
    await scene.robots.update(BATTERY)
    assert scene.joined == {"/robot1"}
    scene.robots.forget("/robot1")
    scene.presence = Presence(frozenset(), publishes=False, base=False)
    await scene.robots.update(DOCK)
    assert scene.joined == {"/robot1"}


@pytest.mark.parametrize(
    ("node", "there"),
    [
        ("/robot1/base", True),
        ("/robot1/legs/left", True),
        ("/robot1/arm/hand", False),
        ("/robot10/base", False),
        ("/rviz", False),
    ],
)
async def test_a_node_belongs_to_the_nearest_robot(scene: Scene, node: str, there: bool) -> None:
    for name in ("/", "/robot1", "/robot1/arm"):
        await scene.robots.open(name)
    scene.presence = Presence(frozenset({node}), publishes=False, base=False)
    assert await scene.robots.is_there("/robot1", Scan()) is there
    assert await scene.robots.is_there("/robot1", Scan(actions={f"{node}/move": []})) is there
    scene.robots.forget("/robot1")
    assert await scene.robots.is_there("/robot1", Scan()) is there


ROOT_DOCK = Scan(actions={"/connect_to_charging_dock": []})


@pytest.mark.parametrize(
    ("scan", "presence", "parts"),
    [
        (ROOT_DOCK, Presence(frozenset(), publishes=False, base=False), {"server"}),
        (Scan(), Presence(frozenset(), publishes=True, base=False), {"battery"}),
        (Scan(), Presence(frozenset(), publishes=False, base=True), {"base"}),
        (Scan(actions={"/fibonacci": []}), Presence(frozenset({"/rviz"}), publishes=False, base=False), set()),
        (DOCK, Presence(frozenset({"/robot1/node"}), publishes=False, base=False), set()),
    ],
)
async def test_the_root_is_a_robot_only_by_its_own_parts(
    scene: Scene, scan: Scan, presence: Presence, parts: set[str]
) -> None:
    await scene.robots.open("/")
    await scene.robots.open("/robot1")
    scene.presence = presence
    topics = {"/rosout": ["rcl_interfaces/msg/Log"], "/parameter_events": ["rcl_interfaces/msg/ParameterEvent"]}
    scan = Scan(actions=scan.actions, topics=topics)
    assert await scene.robots.parts("/", scan) == parts
    assert await scene.robots.is_there("/", scan) is bool(parts)

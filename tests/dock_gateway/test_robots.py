"""Namespaces as clients may write them, and whose an action is."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.errors import InvalidField
from dock_gateway.robots import RobotRegistry, normalize_namespace, read_namespace
from dock_gateway.settings import Settings


@pytest.mark.parametrize(("text", "namespace"), [("", "/"), ("/", "/"), ("robot1", "/robot1"), ("/a/b/", "/a/b")])
def test_settings_are_generous(text: str, namespace: str) -> None:
    assert normalize_namespace(text) == namespace


@pytest.mark.parametrize(("text", "namespace"), [("/", "/"), ("/robot1", "/robot1"), ("/fleet/r_2/", "/fleet/r_2")])
def test_clients_name_a_namespace(text: str, namespace: str) -> None:
    assert read_namespace(text) == namespace


@pytest.mark.parametrize("text", ["", "robot1", "/robot 1", "/1robot", "/a//b", "/a/../b", "/röbot", "/a\0"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(InvalidField):
        read_namespace(text)


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
def test_an_action_belongs_to_the_nearest_robot(action: str, owner: str) -> None:
    nothing: Any = None
    robots = RobotRegistry(Settings(), nothing, nothing, nothing, nothing)
    fakes: Any = {name: SimpleNamespace(namespace=name) for name in ("/", "/robot1", "/robot1/arm")}
    robots._robots = fakes
    found = robots.owner(action)
    assert found is not None
    assert found.namespace == owner
    del fakes["/"]
    assert (robots.owner(action) is None) is (owner == "/")

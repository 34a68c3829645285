"""What is read from the parameters of a docking server, whatever they hold. tests/system has real servers."""

from collections.abc import Iterable, Mapping
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterValue

from dock_gateway.goals.docks import _read_docks
from dock_gateway.ros.parameter_reader import read_value

HOME = {"docks": ["home"], "home.type": "wall", "home.frame": "map", "home.pose": [1.0, 2.5, 0.5]}


class Reader:
    """The parameters of a node."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._values = values

    async def names(self) -> frozenset[str]:
        return frozenset(self._values)

    async def values(self, names: Iterable[str]) -> Mapping[str, Any]:
        return {name: self._values[name] for name in names if name in self._values}


async def docks_of(**odd: object) -> tuple[list[dict[str, Any]], str | None]:
    reader: Any = Reader(HOME | {name.replace("__", "."): value for name, value in odd.items()})
    return await _read_docks(reader)


async def test_a_dock() -> None:
    pose = {"x": 1.0, "y": 2.5, "theta": 0.5}
    home = {"dock_id": "home", "type": "wall", "frame": "map", "tag_id": None, "pose": pose}
    assert await docks_of(dock_database="/docks.yaml") == ([home], "/docks.yaml")


@pytest.mark.parametrize("docks", [1.5, True, "home", [1, 2], [b"home"], []])
async def test_docks_that_are_no_names(docks: object) -> None:
    assert await docks_of(docks=docks) == ([], None)


@pytest.mark.parametrize("pose", [7, "123", ["a", "b", "c"], [1.0, 2.0], [1.0, 2.0, float("nan")], [b"1", [], None]])
async def test_a_pose_that_is_none(pose: object) -> None:
    ((home,), _) = await docks_of(home__pose=pose)
    assert (home["dock_id"], home["pose"]) == ("home", None)


@pytest.mark.parametrize("file", [7, ["/docks.yaml"], ""])
async def test_a_file_that_is_none(file: object) -> None:
    assert (await docks_of(dock_database=file))[1] is None


def test_a_parameter_of_an_unknown_type_is_not_set() -> None:
    assert read_value(ParameterValue(type=42)) is None
    assert read_value(ParameterValue(type=4, string_value="home")) == "home"

"""What is read from the parameters of a docking server, whatever they hold. tests/system has real servers."""

import asyncio
from collections.abc import Iterable, Mapping
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rcl_interfaces.msg import ParameterValue

from dock_gateway.core.dock_adapters import charging_dock, nav2
from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.goals import docks as module
from dock_gateway.goals.docks import Docks, FoundDocks, _read_docks
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


async def docks_of(**odd: object) -> tuple[list[dict[str, Any]], str | None, bool]:
    reader: Any = Reader(HOME | {name.replace("__", "."): value for name, value in odd.items()})
    return await _read_docks(reader)


async def test_a_dock() -> None:
    pose = {"x": 1.0, "y": 2.5, "theta": 0.5}
    home = {"dock_id": "home", "type": "wall", "frame": "map", "tag_id": None, "pose": pose}
    assert await docks_of(dock_database="/docks.yaml") == ([home], "/docks.yaml", True)


@pytest.mark.parametrize("docks", [1.5, True, "home", [1, 2], [b"home"], []])
async def test_docks_that_are_no_names(docks: object) -> None:
    assert await docks_of(docks=docks) == ([], None, isinstance(docks, list))


@pytest.mark.parametrize("pose", [7, "123", ["a", "b", "c"], [1.0, 2.0], [1.0, 2.0, float("nan")], [b"1", [], None]])
async def test_a_pose_that_is_none(pose: object) -> None:
    ((home,), _, _) = await docks_of(home__pose=pose)
    assert (home["dock_id"], home["pose"]) == ("home", None)


@pytest.mark.parametrize("file", [7, ["/docks.yaml"], ""])
async def test_a_file_that_is_none(file: object) -> None:
    assert (await docks_of(dock_database=file))[1] is None


def test_a_parameter_of_an_unknown_type_is_not_set() -> None:
    assert read_value(ParameterValue(type=42)) is None
    assert read_value(ParameterValue(type=4, string_value="home")) == "home"


class Known(Docks):
    """Docks of a server that are not read over ROS. None: it does not answer."""

    def __init__(self, *found: FoundDocks | None) -> None:
        super().__init__(bridge=cast("Any", None))
        self.found = list(found)
        self.reads = 0

    async def _read(self, action: str, family: str) -> FoundDocks:
        self.reads += 1
        found = self.found.pop(0) if len(self.found) > 1 else self.found[0]
        if found is None:
            raise Unavailable("no answer", code="docks_unavailable")
        return found


def found(*names: str, complete: bool = True) -> FoundDocks:
    return FoundDocks("/node", [{"dock_id": name} for name in names], None, complete)


def docking(adapter: DockAdapter = charging_dock.DOCK) -> Any:
    return SimpleNamespace(name="/dock", adapter=adapter)


@pytest.mark.parametrize("names", [(), ("home", "hall")])
async def test_a_dock_that_the_server_does_not_have_is_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(NotFound) as refused:
        await Known(found(*names)).require(docking(), {"dock_id": "lab"})
    assert (refused.value.code, refused.value.extra["docks"]) == ("dock_not_found", [*names])


@pytest.mark.parametrize(
    "request_",
    [
        None,
        {},
        {"dock_id": "home"},
        {"dock_id": "nearest"},
        {"dock_id": 7},
        {"desired_battery_state": {"location": "lab"}},
        {"dock_id": "lab", "dock_pose": {}},
        {"dock_id": "lab", "dock_pose": {}, "use_dock_id": False},
        {"dock_id": "lab", "use_dock_id": False},
    ],
)
async def test_what_names_no_dock_or_one_that_is_there_is_left_to_the_server(request_: object) -> None:
    await Known(found("home")).require(docking(), request_)


async def test_with_its_pose_a_dock_is_named_only_if_its_name_counts() -> None:
    with pytest.raises(NotFound):
        await Known(found("home")).require(docking(), {"dock_id": "lab", "dock_pose": {}, "use_dock_id": True})
    with pytest.raises(NotFound):
        await Known(found("home")).require(docking(nav2.DOCK), {"dock_id": "nearest"})


@pytest.mark.parametrize("unsaid", [None, found("home", complete=False)])
async def test_a_server_that_does_not_say_which_docks_it_has_decides_itself(unsaid: FoundDocks | None) -> None:
    await Known(unsaid).require(docking(), {"dock_id": "lab"})


async def test_a_server_that_takes_its_time_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SAY_WITHIN", 0.01)

    class Slow(Known):
        async def _read(self, action: str, family: str) -> FoundDocks:
            await asyncio.sleep(0.1)
            return found()

    await (docks := Slow(None)).require(docking(), {"dock_id": "lab"})
    await docks.close()


async def test_a_dock_that_was_added_since_the_docks_were_read_is_found() -> None:
    docks = Known(found("home"), found("home", "lab"))
    await docks.require(docking(), {"dock_id": "home"})
    await docks.require(docking(), {"dock_id": "lab"})
    assert docks.reads == 2

"""The file of docks: what the gateway writes, docking servers read; each server reads it again, or that is an alert."""

import asyncio
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.errors import Unavailable
from dock_gateway.extensions.chargers.dock import DockBody, DockPose
from dock_gateway.extensions.chargers.dock_database import render, write
from dock_gateway.extensions.chargers.dock_file import DockFile
from dock_gateway.extensions.chargers.reload_port import ReloadPort
from dock_gateway.extensions.chargers.routes import DOCK_ID
from docking.parameters.dock_database import read_file

METRES = st.floats(-1e6, 1e6)
# Texts, also those that are something else in YAML.
NAMES = st.text(st.characters(categories=("L", "N", "P", "S")), min_size=1, max_size=60) | st.sampled_from(
    ("1", "0x1", "1e3", "on", "no", "null", "~", "- a", "a: b", "#", "{}", "2026-11-30", "=", "<<", "&a", "*a", "!a")
)
POSES = st.builds(DockPose, frame=NAMES, x=METRES, y=METRES, theta=st.floats(-7, 7))
DOCKS = st.builds(DockBody, pose=st.none() | POSES, type=st.none() | NAMES)


@given(st.dictionaries(st.from_regex(DOCK_ID, fullmatch=True), DOCKS, max_size=5))
def test_docking_servers_read_what_is_written(tmp_path_factory: pytest.TempPathFactory, docks: dict[str, Any]) -> None:
    path = tmp_path_factory.mktemp("docks") / "docks.yaml"
    text = render({name: dock.entry().model_dump() for name, dock in docks.items()})
    placed = {name: dock for name, dock in docks.items() if dock.pose is not None and "." not in name}
    assert bool(text) == bool(placed)
    if not text:
        return
    write(path, text)
    found = read_file(str(path))
    assert found.unknown == ()
    assert found.values["docks"] == tuple(sorted(placed))
    for name, dock in placed.items():
        x, y, theta = cast("tuple[float, float, float]", found.values[f"{name}.pose"])
        assert (x, y) == (dock.pose.x, dock.pose.y)
        assert math.cos(theta) == pytest.approx(math.cos(dock.pose.theta), abs=1e-9)
        assert math.sin(theta) == pytest.approx(math.sin(dock.pose.theta), abs=1e-9)
        assert found.values[f"{name}.frame"] == dock.pose.frame
        assert found.values.get(f"{name}.type") == dock.type


class Servers(ReloadPort):
    """The docking servers of two robots, which read a file each, and say what the test wants."""

    def __init__(self, files: dict[str, str | None]) -> None:
        self.files = files
        self.away: set[str] = set()
        self.refuse = ""
        self.read: list[str] = []

    async def document(self, action: str, *_: object) -> dict[str, Any]:
        """Stand in for what is known of a server."""
        robot = action.rpartition("/")[0]
        if robot in self.away:
            raise Unavailable("there is no server")
        return {"node": f"{robot}/docking_server", "dock_database": self.files[robot]}

    async def reload(self, node: str, family: str, path: Path) -> str:
        assert (family, read_file(str(path)).unknown) == ("charging_dock", ())
        if not self.refuse:
            self.read.append(node)
        return self.refuse


class Site:
    """A gateway that keeps a file of docks."""

    def __init__(self, path: Path, servers: Servers) -> None:
        self.known: dict[str, Any] = {}
        actions = [
            SimpleNamespace(name=f"{robot}/dock", verb="dock", family="charging_dock") for robot in servers.files
        ]
        docks = SimpleNamespace(
            book=SimpleNamespace(all=lambda: self.known),
            actions=SimpleNamespace(all=lambda: [*actions, SimpleNamespace(name="/spin", verb=None)]),
            robots=SimpleNamespace(owner=lambda name: SimpleNamespace(namespace=name.rpartition("/")[0])),
        )
        self.file = DockFile(path, cast("Any", docks), cast("Any", servers), servers)

    def place(self, name: str, x: float) -> None:
        """Store a dock with a pose."""
        self.known[name] = DockBody(pose=DockPose(x=x, y=0.0)).entry()

    def keep(self) -> list[tuple[str | None, str]]:
        """Let it look once; return its alerts."""
        asyncio.run(self.file.keep())
        return [(alert.robot, alert.detail) for alert in self.file.alerts()]


def test_a_server_reads_each_change_once_and_others_are_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "made" / "docks.yaml"
    servers = Servers({"/robot1": str(path), "/robot2": "/elsewhere.yaml", "/robot3": None})
    site = Site(path, servers)
    site.known["unplaced"] = DockBody().entry()
    assert (site.keep(), path.exists(), servers.read) == ([], False, [])
    site.place("lab", 1.0)
    for _ in range(3):
        assert site.keep() == []
    assert servers.read == ["/robot1/docking_server"]
    assert "lab" in path.read_text()
    assert "unplaced" not in path.read_text()
    site.place("lab", 2.0)
    assert site.keep() == []
    assert len(servers.read) == 2
    del site.known["lab"]
    assert site.keep() == []
    assert "lab" in path.read_text()  # a server refuses a file without docks


def test_a_server_that_is_away_reads_it_when_it_is_back(tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    servers = Servers({"/robot1": str(path)})
    servers.away = {"/robot1"}
    site = Site(path, servers)
    site.place("lab", 1.0)
    assert (site.keep(), servers.read) == ([], [])
    servers.away = set()
    assert (site.keep(), servers.read) == ([], ["/robot1/docking_server"])


def test_a_server_that_refuses_is_an_alert_until_it_has_read_it(tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    servers = Servers({"/robot1": str(path)})
    servers.refuse = "the docks are as before: their type is unknown"
    site = Site(path, servers)
    site.place("lab", 1.0)
    ((robot, detail),) = site.keep()
    assert (robot, "their type is unknown" in detail) == ("/robot1", True)
    (first,) = site.file.alerts()
    site.keep()
    (second,) = site.file.alerts()
    assert (first.started_at, first.critical) == (second.started_at, True)
    servers.refuse = ""
    assert (site.keep(), len(servers.read)) == ([], 1)


def test_a_file_that_cannot_be_written_is_an_alert_until_it_can(tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    path.mkdir()
    servers = Servers({"/robot1": str(path)})
    site = Site(path, servers)
    site.place("lab", 1.0)
    ((robot, detail),) = site.keep()
    assert (robot, str(path) in detail, servers.read) == (None, True, [])
    assert [*tmp_path.iterdir()] == [path]  # nothing is left over
    path.rmdir()
    assert (site.keep(), len(servers.read)) == ([], 1)

"""The docks that a robot's docking server knows by name: nav2's parameters, which our own server has, too."""

import asyncio
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.dock_adapters.adapter import named_dock
from dock_gateway.core.dock_adapters.charging_dock import FAMILY, NEAREST
from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.core.scene import Pose
from dock_gateway.core.tasks import cancel
from dock_gateway.goals.action import Action
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.parameter_reader import ParameterReader, find_servers

# Seconds for which an answer of a server is used again.
FRESH = 5.0
# Seconds to read everything.
WITHIN = 6.0
# Seconds that a goal waits for the docks.
SAY_WITHIN = 2.0
KEYS = ("type", "frame", "pose", "id")
# The fields of a dock that are texts, and their keys.
TEXTS = {"type": "type", "frame": "frame", "tag_id": "id"}


@dataclass(frozen=True)
class FoundDocks:
    """The docks of a server. `complete`: it has no others, so that each other name is a typing error."""

    node: str
    docks: list[dict[str, Any]]
    file: str | None
    complete: bool


@dataclass(frozen=True)
class _Reading:
    task: "asyncio.Task[FoundDocks]"
    began: float


class Docks:
    """Reads the docks of docking servers on demand, once for all simultaneous requests.

    Args:
        bridge: Runs calls on the ROS thread.
    """

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._readings: dict[str, _Reading] = {}

    async def document(self, action: str, family: str, default: str = "") -> dict[str, Any]:
        """Return the docks of the server of an action, as `GET /docks` shows them.

        Args:
            action: Name of the docking action.
            family: Who defines its type.
            default: The dock that a goal means if it names none; empty: the server's choice.

        Raises:
            Unavailable: It has no server (`action_server_unavailable`), which does not answer (`docks_unavailable`), or
                `ros_unavailable`.
        """
        found = await self._docks_of(action, family)
        first = found.docks[0]["dock_id"] if found.docks and family == FAMILY else None
        return {"node": found.node, "dock_database": found.file, "default": default or first, "docks": found.docks}

    async def require(self, action: Action, request: object) -> None:
        """Check that a robot's docking server has the dock that a request names by `dock_id`, before it is sent.

        A server that does not say which docks it has decides by itself, and so does one that does not answer.

        Raises:
            NotFound: It has not (`dock_not_found`). `docks` are those that it has.
        """
        adapter = action.adapter
        dock = "" if adapter is None or adapter.verb != "dock" else named_dock(request)
        if adapter is None or not dock or (dock == NEAREST and adapter.family == FAMILY):
            return
        try:
            async with asyncio.timeout(SAY_WITHIN):
                for _ in range(2):  # again if it has changed since it was read
                    began, found = time.monotonic(), await self._docks_of(action.name, adapter.family)
                    names = [each["dock_id"] for each in found.docks]
                    if dock in names or not found.complete:
                        return
                    if (reading := self._readings.get(action.name)) is not None and reading.began < began:
                        del self._readings[action.name]
        except (TimeoutError, Unavailable):
            return
        known = f"but {', '.join(names)}" if names else "and no other: it knows none by name"
        raise NotFound(f"the docking server has no dock {dock[:60]!r}, {known}", code="dock_not_found", docks=names)

    async def _docks_of(self, action: str, family: str) -> FoundDocks:
        now = time.monotonic()
        self._readings = {name: each for name, each in self._readings.items() if _is_fresh(each, now)}
        if action not in self._readings:
            task = asyncio.create_task(self._read(action, family))
            task.add_done_callback(lambda done: done.cancelled() or done.exception())  # even if no request waits for it
            self._readings[action] = _Reading(task, now)
        return await asyncio.shield(self._readings[action].task)  # shared with other requests

    async def close(self) -> None:
        """Stop reading."""
        for reading in self._readings.values():
            await cancel(reading.task)

    async def _read(self, action: str, family: str) -> FoundDocks:
        if not (servers := await find_servers(self._bridge, action)):
            raise Unavailable(f"there is no server for {action}")
        node, _ = servers[0]
        reader = ParameterReader(self._bridge, node)
        try:
            async with asyncio.timeout(WITHIN):
                docks, file, lists = await _read_docks(reader)
        except TimeoutError:
            raise Unavailable(
                f"the docking server's node {node} does not answer requests for its parameters",
                code="docks_unavailable",
            ) from None
        finally:
            reader.close()
        # nav2 does not list the docks of a file.
        complete = lists and (not file or (family == FAMILY and bool(docks)))
        return FoundDocks(node, docks, file, complete)


def _is_fresh(reading: _Reading, now: float) -> bool:
    task = reading.task
    return not task.done() or (now - reading.began < FRESH and not task.cancelled() and task.exception() is None)


async def _read_docks(reader: ParameterReader) -> tuple[list[dict[str, Any]], str | None, bool]:
    """Return the docks, the file that has them, and whether the parameters list any or say that there are none."""
    known = await reader.names()
    head = await reader.values(name for name in ("docks", "dock_database") if name in known)
    names = [name for name in _array(head.get("docks")) if isinstance(name, str)]
    values = await reader.values(parameter for name in names for key in KEYS if (parameter := f"{name}.{key}") in known)
    file = head.get("dock_database")
    path = file if file and isinstance(file, str) else None
    return [_document(name, values) for name in names], path, isinstance(head.get("docks"), list)


def _document(name: str, values: Mapping[str, Any]) -> dict[str, Any]:
    pose = _pose(_array(values.get(f"{name}.pose")))
    texts = {field: str(values.get(f"{name}.{key}", "")) or None for field, key in TEXTS.items()}
    return {"dock_id": name, **texts, "pose": None if pose is None else pose._asdict()}


def _array(value: object) -> Sequence[Any]:
    """Return the value of a parameter; an empty one if it is not an array, as the node of another may declare it."""
    return value if isinstance(value, list) else ()


def _pose(numbers: Sequence[Any]) -> Pose | None:
    if len(numbers) != len(Pose._fields):
        return None
    try:
        pose = Pose(*map(float, numbers))
    except (TypeError, ValueError):
        return None
    return pose if all(map(math.isfinite, pose)) else None

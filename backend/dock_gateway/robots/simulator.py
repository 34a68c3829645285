"""The simulators on the graph, as they report themselves."""

import asyncio
import logging
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import orjson

from dock_gateway.core.event import system_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.tasks import cancel
from dock_gateway.robots.registry import RobotRegistry

log = logging.getLogger(__name__)

Fault = Literal[
    "dead_charger",
    "flickering_charge",
    "dirty_contacts",
    "occluded_marker",
    "stuck_wheel",
    "late_commands",
    "lost_commands",
    "no_command_timeout",
    "worn_wheel",
    "wrong_detections",
    "future_detections",
    "lagging_detections",
    "frozen_camera",
    "extrapolating_camera",
    "repeated_odometry",
    "localization_jumps",
    "frozen_odometry",
    "open_loop_odometry",
    "obstacle",
    "occupied_dock",
    "hidden_beacon",
    "frozen_beacon",
    "frozen_scan",
    "infrared_ghosts",
    "silent_battery",
    "percentage_0_to_100",
]
FAULTS: tuple[Fault, ...] = get_args(Fault)

# Seconds without a report after which a simulator is gone; it reports once a second.
GONE_AFTER = 3.5

# The most places of a room.
MAX_PLACES = 100
# The longest name of a place, in characters.
MAX_NAME = 100

Values = Mapping[str, str]


@dataclass
class Simulator:
    """One simulator, as last reported."""

    values: Values
    heard_at: float
    changed: asyncio.Event = field(default_factory=asyncio.Event)
    available: bool = True

    def document(self) -> dict[str, Any]:
        """Return the simulator as `GET /simulator` shows it, ready for `orjson`."""
        return {
            "available": self.available,
            "faults": {fault: self.values[fault] == "true" for fault in FAULTS if fault in self.values},
            "contact": _truth(self.values.get("contact")),
            "docked": _truth(self.values.get("docked")),
            "battery_publisher": self.values.get("battery_publisher"),
            "real_time_factor": _number(self.values.get("real_time_factor")),
            "too_slow": _truth(self.values.get("too_slow")),
            "places": _places(self.values.get("places")),
        }


class Simulators:
    """The simulators by robot.

    Args:
        fanout: Receives events.
        robots: The robots. Reports of other namespaces are not taken.
        gone_after: See `GONE_AFTER`.
    """

    def __init__(self, fanout: Fanout, robots: RobotRegistry, *, gone_after: float = GONE_AFTER) -> None:
        self._gone_after = gone_after
        self._fanout = fanout
        self._robots = robots
        self._simulators: dict[str, Simulator] = {}
        self._task = asyncio.create_task(self._watch())

    def on_report(self, namespace: str, values: Values) -> None:
        """Handle a simulator's report."""
        if namespace not in self._robots:
            return
        known = self._simulators.get(namespace)
        if known is None:
            self._simulators[namespace] = Simulator(values, time.monotonic())
            log.info("simulator of %s", namespace)
            self._publish(namespace)
            return
        before = known.document()
        known.values, known.heard_at, known.available = values, time.monotonic(), True
        known.changed.set()
        if known.document() != before:
            self._publish(namespace)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(1.0)
            for namespace, simulator in list(self._simulators.items()):
                if namespace not in self._robots:
                    del self._simulators[namespace]
                elif simulator.available and time.monotonic() - simulator.heard_at > self._gone_after:
                    log.info("the simulator of %s left the ROS graph", namespace)
                    simulator.available = False
                    self._publish(namespace)

    def _publish(self, namespace: str) -> None:
        self._fanout.publish(system_event("simulator", self.document(namespace), utc_now(), robot=namespace))

    def find(self, namespace: str) -> Simulator | None:
        """Return the simulator of a robot, or None if there is none or it is gone."""
        simulator = self._simulators.get(namespace)
        return simulator if simulator is not None and simulator.available else None

    def __contains__(self, namespace: str) -> bool:
        return self.find(namespace) is not None

    def document(self, namespace: str) -> dict[str, Any] | None:
        """Return the last report of a robot's simulator, even if it is gone; None if there never was one."""
        simulator = self._simulators.get(namespace)
        return None if simulator is None else simulator.document()

    async def close(self) -> None:
        """Stop watching."""
        await cancel(self._task)


def _truth(text: str | None) -> bool | None:
    return None if text is None else text == "true"


def _number(text: str | None) -> float | None:
    try:
        number = None if text is None else float(text)
    except ValueError:
        return None
    return number if number is not None and math.isfinite(number) else None


def _places(text: str | None) -> list[dict[str, Any]]:
    """Return the places that a report has as JSON: `{"shelf": [x, y, theta]}`. What is none is left out."""
    try:
        places = orjson.loads(text or "{}")
    except orjson.JSONDecodeError:
        return []
    if not isinstance(places, dict):
        return []
    named = [(name, pose) for name, pose in places.items() if 0 < len(name) <= MAX_NAME and _is_pose(pose)]
    return [dict(zip(("name", "x", "y", "theta"), (name, *pose), strict=True)) for name, pose in named[:MAX_PLACES]]


def _is_pose(pose: object) -> bool:
    return isinstance(pose, list) and len(pose) == 3 and all(type(number) in {int, float} for number in pose)

"""What a hub reads of a site, without ROS: robots whose state changes, goals that run for a moment, events with ids."""

import asyncio
import contextlib
import random
import time
import uuid
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import orjson

from dock_gateway.core.event import Event, fleet_event, result_event, status_event, stop_event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus, encode
from dock_gateway.core.narrowing import narrow_robots
from dock_gateway.stop.stop_report import latched_stops

ACTION_TYPE = "action_tutorials_interfaces/action/ConnectToChargingDock"
# Seconds between two reports of the robots that have changed: as `fleet.fleet` does it.
REPORT_PERIOD = 0.5


class Journal:
    """What outlives a site's process: a line for each change, written before it is told to anyone."""

    def __init__(self, path: Path | None) -> None:
        self._lines = path.read_bytes().splitlines() if path is not None and path.exists() else []
        self._file = None if path is None else path.open("ab", buffering=0)

    def read(self) -> list[dict[str, Any]]:
        """Everything that was written; a last line that was cut off is no part of it."""
        entries = []
        for line in self._lines:
            with contextlib.suppress(orjson.JSONDecodeError):
                entries.append(orjson.loads(line))
        return entries

    def write(self, **entry: Any) -> None:
        """Write an entry; a killed process has written all of it or, at the end of the file, a part."""
        if self._file is not None:
            self._file.write(b"\n" + encode(entry))


class SimulatedSite:
    """The robots `/robot1`, `/robot2`, … of one site.

    Args:
        name: Of the site.
        robots: How many.
        journal: What it remembers.
        change_period: Seconds between two changes of each robot's battery; 0: they do not change.
    """

    def __init__(self, name: str, robots: int, journal: Journal, *, change_period: float = 0.0) -> None:
        self.name = name
        self.fanout = Fanout(queue_limit=1000)
        self.goals: dict[str, Goal] = {}
        self.stops: dict[str, dict[str, Any]] = {}
        self.executed: list[int] = []
        self.events: list[Event] = []  # those with ids, oldest first
        self.installation = uuid.uuid4().hex
        self._robots = [f"/robot{number}" for number in range(1, robots + 1)]
        self._keys: dict[str, str] = {}
        self._journal = journal
        self._change_period = change_period
        self._changed_at = {robot: self.now() for robot in self._robots}
        self._changed = set(self._robots)
        self._last_stamp = 0
        self._running: set[asyncio.Task[None]] = set()
        self._recover()

    # ------------------------------------------------------------------ time

    def now(self) -> datetime:
        """The time by the site's clock, which may be off."""
        return datetime.fromtimestamp(time.time(), UTC)

    def _stamp(self) -> int:
        self._last_stamp = max(self._last_stamp + 1, int(time.time() * 1e9))
        return self._last_stamp

    # --------------------------------------------------------------- journal

    def _recover(self) -> None:
        fresh = True
        for entry in self._journal.read():
            fresh = False
            self.installation = entry.get("installation", self.installation)
            if (document := entry.get("goal")) is not None:
                goal = _goal(document)
                self.goals[goal.goal_id] = goal
                if entry.get("key"):
                    self._keys[entry["key"]] = goal.goal_id
                if entry.get("number") is not None:
                    self.executed.append(entry["number"])
            for event in entry.get("events", ()):
                self.events.append(Event(**{**event, "data": event["data"].encode()}))
            if "stops" in entry:
                self.stops = entry["stops"]
        if self.events:
            self._last_stamp = int((self.events[-1].id or "0")[:20])
        if fresh:
            self._journal.write(installation=self.installation)

    def _commit(self, goal: Goal, *makers: Callable[[Goal, int], Event], **more: Any) -> None:
        """Store a goal and its new events at once, then tell the readers."""
        events = [make(goal, self._stamp()) for make in makers]
        stored = [
            {
                "data": event.data.decode(),
                **{
                    name: getattr(event, name) for name in ("topic", "goal_id", "action_name", "id", "ends_goal", "key")
                },
            }
            for event in events
        ]
        self._journal.write(goal=goal.document(), events=stored, **more)
        self._changed.add(goal.action_name.rpartition("/")[0])
        self.events.extend(events)
        for event in events:
            self.fanout.publish(event)

    # ----------------------------------------------------------------- goals

    def send(self, robot: str, seconds: float, number: int | None, key: str | None) -> Goal:
        """Accept a goal, or return the one that has this key already."""
        if key is not None and key in self._keys:
            return self.goals[self._keys[key]]
        now = self.now()
        goal = Goal(str(uuid.uuid4()), f"{robot}/dock", ACTION_TYPE, now, verb="dock")
        goal.status, goal.updated_at = GoalStatus.EXECUTING, now
        goal.goal = encode({"seconds": seconds})
        self.goals[goal.goal_id] = goal
        if key is not None:
            self._keys[key] = goal.goal_id
        if number is not None:
            self.executed.append(number)
        self._commit(goal, status_event, number=number, key=key)
        self._later(seconds, goal)
        return goal

    def _later(self, seconds: float, goal: Goal) -> None:
        async def run() -> None:
            await asyncio.sleep(seconds)
            self.end(goal, GoalStatus.SUCCEEDED)

        task = asyncio.create_task(run())
        self._running.add(task)
        task.add_done_callback(self._running.discard)

    def end(self, goal: Goal, status: GoalStatus) -> None:
        """End a goal that has not ended."""
        if goal.status.terminal:
            return
        goal.status, goal.finished_at, goal.updated_at = status, self.now(), self.now()
        goal.result = encode({"final_battery_state": {"percentage": 0.5}})
        self._commit(goal, status_event, result_event)

    # ----------------------------------------------------------------- stops

    def stop(self, robots: list[str], by: str | None) -> dict[str, Any]:
        """Latch stops; without a robot for all of them."""
        for robot in robots or ["/"]:
            self.stops.setdefault(robot, {"stopped_at": self.now().isoformat(), "by": by})
        self._journal.write(stops=self.stops)
        canceled = [goal for goal in self.goals.values() if not goal.status.terminal and self._held(goal.action_name)]
        for goal in canceled:
            self.end(goal, GoalStatus.CANCELED)
        self._stops_changed()
        return {
            "stopped": self.stop_state(robots[0] if robots else "/")["robots"],
            "not_stopped": [],
            "canceling": sorted({goal.action_name for goal in canceled}),
            "failed": [],
            "unconfirmed": [],
            "stop": self.latched_stops(robots[0] if robots else "/"),
            "others": [],
            "warning": None,
        }

    def release(self, robot: str) -> dict[str, Any]:
        """Release the stops of a robot and of those below it."""
        self.stops = {name: stop for name, stop in self.stops.items() if robot not in ("/", name)}
        self._journal.write(stops=self.stops)
        self._stops_changed()
        return self.latched_stops(robot)

    def _stops_changed(self) -> None:
        self._changed.update(self._robots)
        state = self.stop_state("/")
        self.fanout.publish(stop_event(state, None, robot="/"))

    def _held(self, name: str) -> bool:
        return any(name.startswith(f"{robot.rstrip('/')}/") or name == robot for robot in self.stops)

    def latched_stops(self, robot: str) -> dict[str, Any]:
        """As `GET /stop` shows it."""
        return latched_stops(self.stop_state(robot), self.stop_state)

    def stop_state(self, robot: str) -> dict[str, Any]:
        """As the robot itself shows it."""
        holding = self.stops.get(robot) or self.stops.get("/")
        held = [name for name in self._robots if self._held(name) and (robot in ("/", name))]
        since, by = (holding["stopped_at"], holding["by"]) if holding else (None, None)
        return {"latched": holding is not None, "stopped_at": since, "by": by, "robots": held, "persisted": True}

    # ---------------------------------------------------------------- robots

    def robots(self, names: set[str] | None = None) -> list[dict[str, Any]]:
        """Robots as `GET /robots` shows them."""
        wanted = self._robots if names is None else [name for name in self._robots if name in names]
        running: dict[str, list[dict[str, Any]]] = {}
        for goal in self.goals.values():
            if not goal.status.terminal:
                running.setdefault(goal.action_name.rpartition("/")[0], []).append(goal.state())
        return [self._robot(name, running.get(name, [])) for name in wanted]

    def _robot(self, name: str, goals: list[dict[str, Any]]) -> dict[str, Any]:
        server = {"action_type": ACTION_TYPE, "available": True, "answering": True, "duplicate": False}
        at = self._changed_at[name]
        charge = at.timestamp() % 60 / 60
        return {
            "name": name,
            "display_name": None,
            "groups": [],
            "default": name == "/robot1",
            "docked": False,
            "charging": False,
            "simulated": True,
            "battery": {
                "state": {
                    "header": {"stamp": {"sec": int(at.timestamp()), "nanosec": at.microsecond * 1000}, "frame_id": ""},
                    **dict.fromkeys(("voltage", "temperature", "current", "charge", "capacity"), 12.1 + charge),
                    "design_capacity": 2.4,
                    "percentage": charge,
                    "power_supply_status": 2,
                    "power_supply_health": 1,
                    "power_supply_technology": 0,
                    "present": True,
                    "cell_voltage": [],
                    "cell_temperature": [],
                    "location": "",
                    "serial_number": "",
                },
                "percentage": charge,
                "implausible": [],
                "received_at": at,
                "stale": False,
                "stale_after_s": 5.0,
                "low_below": 0.2,
            },
            "battery_topic": f"{name}/battery_status",
            "battery_publisher": {"active": False, "rate_hz": None},
            "stop": self.stop_state(name),
            "dock": {"action_name": f"{name}/dock", **server},
            "undock": {"action_name": f"{name}/undock", **server},
            "join": None,
            "goals": goals,
            "last_goal": None,
        }

    async def run(self) -> None:
        """Change the robots, and report them; for ever. Goals that an earlier process began end soon."""
        for goal in self.goals.values():
            if not goal.status.terminal:
                self._later(0.2, goal)
        async with asyncio.TaskGroup() as group:
            group.create_task(self._report())
            if self._change_period:
                for robot in self._robots:
                    group.create_task(self._change(robot))

    async def _change(self, robot: str) -> None:
        await asyncio.sleep(random.uniform(0, self._change_period))
        while True:
            self._changed_at[robot] = self.now()
            self._changed.add(robot)
            await asyncio.sleep(self._change_period)

    async def _report(self) -> None:
        await asyncio.sleep(random.uniform(0, REPORT_PERIOD))
        while True:
            if self._changed:
                changed, self._changed = self._changed, set()
                self.fanout.publish(
                    fleet_event("robots", self.now(), narrow_robots, robots=self.robots(changed), gone=[])
                )
            await asyncio.sleep(REPORT_PERIOD)


def _goal(document: dict[str, Any]) -> Goal:
    """A goal out of its document."""
    times = ("created_at", "updated_at", "finished_at")
    dates = {name: document[name] and datetime.fromisoformat(document[name]) for name in times}
    goal = Goal(document["goal_id"], document["action_name"], document["action_type"], dates["created_at"])
    goal.verb, goal.origin, goal.status = document["verb"], document["origin"], GoalStatus(document["status"])
    goal.updated_at, goal.finished_at = dates["updated_at"], dates["finished_at"]
    goal.goal, goal.result = (document[name] and encode(document[name]) for name in ("goal", "result"))
    goal.last_event_id = document["last_event_id"]
    return goal

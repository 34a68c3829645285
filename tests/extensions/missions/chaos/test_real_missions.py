"""Missions of real robots, gateways and a database, of which gateways and robots are killed again and again.

`CHAOS_MISSIONS=3600` does so for an hour.
"""

import os
import random
import time
from collections import Counter, defaultdict
from contextlib import ExitStack
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from docking.simulation.hall import Hall
from tests.chaos.fleet import Fleet, wait_for_action
from tests.chaos.report import report
from tests.extensions.missions.chaos.hall import Watch, kill_a_robot
from tests.extensions.missions.chaos.operators import PLACES, Operators
from tests.support.installed import needs
from tests.support.observer import Observer
from tests.support.postgresql import binaries, running_postgresql
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

SECONDS = float(os.environ.get("CHAOS_MISSIONS", "0"))

pytestmark = [
    pytest.mark.ros,
    pytest.mark.timeout(7200),
    pytest.mark.skipif(binaries() is None, reason="no PostgreSQL is installed"),
    pytest.mark.skipif(not SECONDS, reason="takes minutes: `make chaos`, or CHAOS_MISSIONS=60"),
    needs("chargers", "simulator", "maps"),
]

GATEWAY_EVERY, ROBOT_EVERY = 15.0, 60.0  # seconds between two kills
SETTLES_WITHIN = 600.0
# Seconds by which the clock of a goal and the sight of a robot may differ.
SEEN_WITHIN = 2.0
HALL = Hall(3, 2)
ENDED = ("succeeded", "failed", "canceled")


def test_missions_while_gateways_and_robots_are_killed(domain: int, observer: Observer, tmp_path: Path) -> None:
    hall = ("-m", "docking.nodes.simulated_fleet", str(HALL.robots), "--docks", str(HALL.docks))
    executed = tmp_path / "executed"
    actions = ("-m", "tests.support.busy_action_server", "--executed", str(executed), "--cancelable")
    with ExitStack() as stack:
        robots = stack.enter_context(ForkedProcess(*hall, env=ros_environment(domain)))
        stack.enter_context(ForkedProcess(*actions, env=ros_environment(domain))).wait_for("serving")
        database = stack.enter_context(running_postgresql()).url
        settings = {"namespace": "/robot1", "database_url": database, "spool_path": f"{tmp_path}/spool"}
        fleet = stack.enter_context(Fleet(domain, 2, **settings))
        operators = Operators(fleet.url, HALL.dock_names)
        set_up(fleet, operators)
        watch = Watch(observer, HALL)
        began, kills = time.monotonic(), Counter[str]()
        operators.start()
        due = {"gateway": began + GATEWAY_EVERY / 2, "robot": began + ROBOT_EVERY / 3}
        while (now := time.monotonic()) < began + SECONDS:
            assert operators.is_alive(), operators.error
            if now > due["gateway"]:
                number = random.randrange(2)
                fleet.kill(number)
                time.sleep(random.choice([0.0, 2.0]))
                fleet.start(number)
                due["gateway"] = now + random.uniform(0.5, 1.5) * GATEWAY_EVERY
                kills["gateway"] += 1
            if now > due["robot"]:
                kill_a_robot(robots)
                due["robot"] = now + random.uniform(0.5, 1.5) * ROBOT_EVERY
                kills["robot"] += 1
            watch.look(time.time())
            time.sleep(0.1)
        operators.finish()
        ended = settle(operators, watch)
        watch.end(time.time())
        check(ended, executed, two_at_one_dock(docking_goals(fleet), watch), figures(operators, fleet, watch, kills))


def set_up(fleet: Fleet, operators: Operators) -> None:
    """Wait for robots and actions; share the docks, and put the robots into a group."""
    wait_for_action(fleet)
    for gateway in fleet.running.values():
        for robot in PLACES:
            at = {"robot": robot}
            wait_until(lambda http=gateway.http, at=at: http.get("/docks", params=at).status_code == 200, robot)
    for dock in HALL.dock_names:
        assert operators.ask("PUT", f"/shared-docks/{dock}", json={}).status_code == 201
    for robot in PLACES:
        label = {"display_name": None, "groups": ["all"]}
        assert operators.ask("PUT", "/label", params={"robot": robot}, json=label).is_success


def settle(operators: Operators, watch: Watch) -> dict[str, dict[str, Any]]:
    """Let all missions go on until they have ended; return them."""
    deadline = time.monotonic() + SETTLES_WITHIN
    ended: dict[str, dict[str, Any]] = {}
    while operators.queued - ended.keys():
        operators.ask("DELETE", "/stop")  # a gateway that was away at a release has brought the stop back
        operators.go_on()
        for mission_id in operators.queued - ended.keys():
            mission = operators.ask("GET", f"/missions/{mission_id}").json()
            assert mission.get("mission_id") == mission_id, mission
            if mission["status"] in ENDED:
                ended[mission_id] = mission
            else:
                assert time.monotonic() < deadline, mission
        watch.look(time.time())
        time.sleep(0.5)
    return ended


def figures(operators: Operators, fleet: Fleet, watch: Watch, kills: Counter[str]) -> dict[str, Any]:
    """What has happened."""
    return {
        "seconds": SECONDS,
        "gateways killed": kills["gateway"],
        "robots killed": kills["robot"],
        "stays on docks": len(watch.stays),
        "answers": dict(operators.answers),
        "warnings": dict(fleet.warnings()),
    }


def check(missions: dict[str, dict[str, Any]], executed: Path, shared: list[str], figures: dict[str, Any]) -> None:
    """What must hold, whatever was killed."""
    began = Counter(map(int, executed.read_text().split()))
    steps = [step for mission in missions.values() for step in mission["steps"]]
    work = {step["action"]["goal"]["order"]: step for step in steps if step["action"] is not None}
    again = {order: count for order, count in began.items() if count > work[order]["attempt"]}
    not_done = [order for order, step in work.items() if step["status"] == "succeeded" and not began[order]]
    open_steps = [
        mission["mission_id"]
        for mission in missions.values()
        if mission["status"] == "succeeded" and {step["status"] for step in mission["steps"]} & {"waiting", "running"}
    ]
    report(
        "Missions of three robots with two docks; gateways and robots are killed",
        {
            "missions": len(missions),
            **{f"missions that {status}": n for status, n in Counter(m["status"] for m in missions.values()).items()},
            "steps": len(steps),
            "goals of other actions": sum(began.values()),
            "steps carried out once more than tried": len(again),
            "steps that succeeded and were not carried out": len(not_done),
            "missions that succeeded with a step left out": len(open_steps),
            "robots sent to a dock where another one stood": len(shared),
            **figures,
        },
    )
    assert missions
    assert again == {}
    assert not_done == []
    assert open_steps == []
    assert shared == []


def two_at_one_dock(goals: list[dict[str, Any]], watch: Watch) -> list[str]:
    """What docking goals tell of two robots at one dock: one drove to it, and another one stood there or drove, too."""
    drives = defaultdict(list)
    for goal in goals:
        dock = goal["goal"]["desired_battery_state"]["location"]
        since, until = (datetime.fromisoformat(goal[name]).timestamp() for name in ("created_at", "finished_at"))
        drives[dock].append((goal["action_name"].rpartition("/")[0], since, until, goal["goal_id"]))
    found = []
    for dock, all_drives in drives.items():
        for robot, since, until, goal_id in all_drives:
            others = [(other, *times, "drives there") for other, *times, _ in all_drives]
            others += [(other, *times, "stands there") for name, other, *times in watch.stays if name == dock]
            for other, first, last, what in others:
                if other != robot and first < until - SEEN_WITHIN and last > since + SEEN_WITHIN:
                    found.append(f"{robot} is sent to {dock} ({goal_id}) while {other} {what}")
    return found


def docking_goals(fleet: Fleet) -> list[dict[str, Any]]:
    """Return all docking goals that robots carried out."""
    goals, cursor = [], None
    while True:
        query: dict[str, Any] = {"limit": 100, "verb": "dock"} | ({"cursor": cursor} if cursor else {})
        page = fleet.any().http.get("/goals", params=query).raise_for_status().json()
        goals += [goal for goal in page["goals"] if goal["status"] in ("succeeded", "aborted", "canceled")]
        if (cursor := page.get("next_cursor")) is None:
            return goals

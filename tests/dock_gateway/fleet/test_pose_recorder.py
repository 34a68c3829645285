"""Which poses of a goal are stored, and when a robot is listened to."""

from types import SimpleNamespace
from typing import Any, cast

import orjson
import pytest

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.fleet.pose_recorder import INTERVAL_NS, GoalPoses, PoseRecorder, differs
from dock_gateway.robots.registry import Robot
from tests.support.history import START_NS, make_goal

SLOT = START_NS // INTERVAL_NS * INTERVAL_NS


def scene(x: float = 0.0, theta: float = 0.0, **more: Any) -> dict[str, Any]:
    pose = {"x": x, "y": 0.0, "theta": theta}
    nothing = {"dock": None, "docked": None, "staging": None, "marker": None, "infrared": None, "footprint": None}
    return {"frame": "odom", "robot": pose, **nothing, **more}


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (scene(0.004, 0.009), False),
        (scene(0.006), True),
        (scene(0.0, 0.02), True),
        (scene(0.0, 6.2830), False),
        (scene(frame="world"), True),
        (scene(dock={"x": 1.0, "y": 0.0, "theta": 0.0}), True),
        (scene(footprint={"radius": 0.3, "points": None}), True),
        (scene(marker={"x": 1.0, "y": 0.0, "theta": 0.0}), False),
    ],
)
def test_what_differs(other: dict[str, Any], *, expected: bool) -> None:
    assert differs(scene(), other) is expected
    assert differs(other, scene()) is expected


def test_at_most_five_a_second_and_only_what_changed() -> None:
    poses = GoalPoses()
    assert poses.take(scene(0.0), SLOT + 5) == SLOT
    assert poses.take(scene(1.0), SLOT + INTERVAL_NS - 1) is None
    assert poses.take(scene(0.001), SLOT + INTERVAL_NS) is None
    assert poses.take(scene(1.0), SLOT + 3 * INTERVAL_NS + 7) == SLOT + 3 * INTERVAL_NS
    assert poses.take(scene(2.0), SLOT) is None


def test_two_gateways_use_the_same_stamps() -> None:
    stamps = [GoalPoses().take(scene(), SLOT + offset) for offset in (1, INTERVAL_NS // 2)]
    assert stamps == [SLOT, SLOT]


def test_a_long_goal_is_stored_more_thinly() -> None:
    poses = GoalPoses(thin_after=10)
    times = [number * INTERVAL_NS for number in range(1, 1000)]
    stored = [each for each in times if poses.take(scene(each / INTERVAL_NS), each) is not None]
    assert len(stored) < 80
    assert stored[:10] == times[:10]
    assert stored[-1] > times[-300]


async def test_robots_with_running_goals_are_listened_to() -> None:
    running: list[Goal] = []
    changes: list[set[str]] = []
    stored: list[Event] = []
    robots = {"/robot1/dock": cast("Robot", SimpleNamespace(namespace="/robot1"))}
    recorder = PoseRecorder(lambda: running, robots.get, stored.append)
    recorder.on_watch("poses", lambda: changes.append(recorder.watched("poses")))
    external = make_goal(1, GoalStatus.EXECUTING, "/robot1/dock", origin="external")
    running += [external, make_goal(2, GoalStatus.EXECUTING, "/elsewhere/dock")]
    recorder.scan()
    recorder.scan()
    assert changes == [{"/robot1"}]
    recorder.hear("/robot1", scene(), START_NS)
    recorder.hear("/robot2", scene(), START_NS)
    (event,) = stored
    assert (event.topic, event.goal_id, event.droppable, event.key) == ("poses", "goal-0001", True, event.id)
    document = orjson.loads(event.data)
    assert (document["type"], document["scene"], document["id"]) == ("pose", scene(), event.id)
    external.status = GoalStatus.ABORTED
    recorder.hear("/robot1", scene(5.0), START_NS + 10 * INTERVAL_NS)
    assert len(stored) == 1
    running.clear()
    recorder.scan()
    assert changes == [{"/robot1"}, set()]
    await recorder.close()

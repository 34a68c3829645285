"""Our own docking actions: which goals come of a request."""

import json

import pytest

from dock_gateway.core.dock_adapters.charging_dock import DOCK, UNDOCK
from dock_gateway.core.errors import InvalidField
from dock_gateway.core.goal import GoalStatus


def test_a_request_without_a_dock_is_sent_as_it_is() -> None:
    for request in (DOCK.default, {}, {"desired_battery_state": {"power_supply_status": 4}}, {"typo": 1}):
        assert DOCK.goal(request) == request
    assert UNDOCK.goal(UNDOCK.default) == {"desired_battery_state": {}}


def test_the_location_of_the_battery_names_the_dock() -> None:
    home = {"desired_battery_state": {"power_supply_status": 1, "location": "home"}}
    assert DOCK.goal({"dock_id": "home"}) == home
    assert DOCK.goal(DOCK.default, "home") == home
    full = {"desired_battery_state": {"power_supply_status": "FULL"}}
    named = {"desired_battery_state": {"power_supply_status": "FULL", "location": "home"}}
    assert DOCK.goal({**full, "dock_id": "home"}) == DOCK.goal(full, "home") == named
    assert DOCK.goal(home, "other") == home, "who names a dock means that one"


@pytest.mark.parametrize(
    ("request_", "path"),
    [
        ({"dock_id": ""}, "goal.dock_id"),
        ({"dock_id": None}, "goal.dock_id"),
        ({"dock_id": 7}, "goal.dock_id"),
        ({"dock_id": "a", "desired_battery_state": {"location": "b"}}, "goal.desired_battery_state.location"),
    ],
)
def test_a_dock_that_is_none(request_: dict[str, object], path: str) -> None:
    with pytest.raises(InvalidField) as refused:
        DOCK.goal(request_, path="goal")
    assert refused.value.extra["errors"][0]["path"] == path


def pose(**place: object) -> dict[str, object]:
    """A geometry_msgs/PoseStamped as its codec completes it."""
    turn = {"x": 0.0, "y": 0.0, "z": 1.0, "w": 0.0}
    position = {"x": 4.2, "y": -1.0, "z": 0.0}
    whole = {"frame_id": "map", "position": position, "orientation": turn, **place}
    return {"header": {"frame_id": whole.pop("frame_id")}, "pose": whole}


def test_a_pose_is_a_dock_without_a_name() -> None:
    described = DOCK.goal({"dock_pose": pose(), "dock_type": "wall", "use_dock_id": False}, "home")
    assert json.loads(described["desired_battery_state"].pop("location")) == {
        "frame": "map",
        "pose": [4.2, -1.0, 3.141593],
        "type": "wall",
    }
    assert described == {"desired_battery_state": {"power_supply_status": 1}}
    named = DOCK.goal({"dock_pose": pose(), "dock_id": "lab", "use_dock_id": True})
    assert named == {"desired_battery_state": {"power_supply_status": 1, "location": "lab"}}


@pytest.mark.parametrize(
    ("request_", "path"),
    [
        ({"dock_pose": pose(), "dock_id": "lab"}, "use_dock_id"),
        ({"dock_pose": pose(), "dock_type": 7}, "dock_type"),
        ({"dock_pose": pose(frame_id="")}, "dock_pose.header.frame_id"),
        ({"dock_pose": pose(position={"x": None, "y": 0.0, "z": 0.0})}, "dock_pose.pose"),
        ({"dock_pose": pose(position={"x": 1e12, "y": 0.0, "z": 0.0})}, "dock_pose.pose"),
        ({"dock_pose": pose(orientation=dict.fromkeys("xyzw", 0.0))}, "dock_pose.pose"),
    ],
)
def test_a_pose_that_is_none(request_: dict[str, object], path: str) -> None:
    with pytest.raises(InvalidField) as refused:
        DOCK.goal(request_)
    assert refused.value.extra["errors"][0]["path"] == path


def test_what_is_no_battery_state_is_left_to_the_codec() -> None:
    assert DOCK.goal({"desired_battery_state": 7, "dock_id": "a"}) == {"desired_battery_state": 7, "dock_id": "a"}


def test_the_dock_to_leave_has_no_name() -> None:
    with pytest.raises(InvalidField, match="dock_id"):
        UNDOCK.goal({"dock_id": "home"})


def test_messages_say_nothing_that_is_not_reported_elsewhere() -> None:
    assert not DOCK.tells_stage
    assert DOCK.outcome(GoalStatus.ABORTED, {"final_battery_state": {}}).error is None

"""The program `docking_replay`: what the docking server of today would decide on the sensors of a recorded goal."""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import yaml
from rclpy.exceptions import ParameterException

from docking.nodes.dock_server import DockAction
from docking.nodes.undock_server import UndockAction
from docking.replay.comparison import Difference, differences
from docking.replay.course import Course
from docking.replay.recorded_goal import RecordedGoal, read_goal
from docking.ros.process import EXIT_USAGE, ros_context, run_process
from docking.ros.recorded_course import as_the_server_said
from docking.ros.replay import LAGS, Replay
from docking.ros.robot_action import RobotAction
from robot_io.children import run_apart
from robot_io.rclpy_private import RCLError

USAGE = "usage: docking_replay FILE.mcap [--ros-args …]"
EXIT_DIFFERENT = 1
"""Exit code: it would decide otherwise."""
WITHIN = 3600
"""Seconds of real time that a replay may take: the longest one needs less on a slow machine."""
ACTIONS: dict[str, type[RobotAction[Any]]] = {
    "action_tutorials_interfaces/action/ConnectToChargingDock": DockAction,
    "action_tutorials_interfaces/action/DisconnectFromChargingDock": UndockAction,
}
GUESSED = {
    "battery_status": "sensor_msgs/msg/BatteryState",
    "odom": "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
}
"""Topics that may have another name, and their types."""


def main(args: Sequence[str] | None = None) -> int:
    """Replay a recording.

    Returns:
        0 if the goal takes the recorded course, 1 if it does not, 2 if it cannot be replayed, or if the recording does
        not allow a verdict.
    """
    # No robot may receive the velocities that are commanded here.
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
    os.environ.pop("ROS_STATIC_PEERS", None)
    arguments = sys.argv[1:] if args is None else args
    code = run_apart(lambda: run_process(_replay, arguments), WITHIN)
    if code is None:
        print("error: the replay crashed, or took too long", file=sys.stderr)  # noqa: T201 - there is no node to log with
        return EXIT_USAGE
    return code


def _replay(args: Sequence[str] | None) -> int:
    files, ros_args = _split(args or ())
    if len(files) != 1 or files[0].startswith("-"):
        raise ValueError(USAGE)
    goal = read_goal(Path(files[0]))
    if (action := ACTIONS.get(goal.action_type)) is None:
        raise ValueError(f"{goal.action_type} is not an action of our docking server: only its goals can be replayed")
    if not goal.parameters and not ros_args:
        raise ValueError(
            "the recording does not have the parameters of the action server, which did not tell them: give those that"
            " it had, after --ros-args"
        )
    try:
        return _compare(as_the_server_said(goal), action, ros_args)
    except (ParameterException, ValueError, RCLError):
        raise
    except Exception as error:  # whatever a made up recording brings about
        raise ValueError(f"the goal cannot be replayed: {type(error).__name__}: {error}") from error


def _compare(goal: RecordedGoal, action: type[RobotAction[Any]], ros_args: Sequence[str]) -> int:
    """Replay a goal with each lag, until it takes the recorded course; print the replay that comes nearest."""
    found: list[tuple[Replay, list[Difference]]] = []
    with NamedTemporaryFile("w", suffix=".yaml") as file:
        yaml.safe_dump({"/**": {"ros__parameters": goal.parameters}}, file)
        file.flush()
        given = ["--params-file", file.name] if goal.parameters else []
        with ros_context(["replay", "--ros-args", *given, *_arguments(goal), *ros_args]) as context:
            for lag in LAGS:
                replay = Replay(goal, action(), context, lag)
                try:
                    replay.run()
                finally:
                    replay.close()
                found.append((replay, differences(replay.recorded, replay.replayed)))
                if not found[-1][1]:
                    break
    replay, others = min(found, key=lambda each: len(each[1]))
    _tell(goal, replay, others)
    if not others:
        return 0
    if (doubt := replay.find_doubt(min(each.at for each in others))) is not None:
        raise ValueError(f"the recording does not allow a verdict: {doubt}")
    return EXIT_DIFFERENT


def _split(args: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the program's own arguments, and those of ROS."""
    own = list(args)
    with suppress(ValueError):
        at = own.index("--ros-args")
        return own[:at], own[at + 1 :]
    return own, []


def _arguments(goal: RecordedGoal) -> list[str]:
    """Return the ROS arguments that make a server for the recorded robot."""
    topics, robot = goal.topics(), goal.robot.rstrip("/")
    remaps = [f"__ns:={goal.robot}"]
    for name, kind in GUESSED.items():
        of_kind = [topic for topic, each in topics.items() if each == kind]
        if f"{robot}/{name}" not in topics and len(of_kind) == 1:
            remaps.append(f"{name}:={of_kind[0]}")
    remaps += [f"{name}:=/{name}" for name in ("tf", "tf_static") if robot and f"{robot}/{name}" not in topics]
    arguments = [argument for remap in remaps for argument in ("-r", remap)]
    return [*arguments, "-p", "use_sim_time:=true", "--log-level", "fatal"]


def _tell(goal: RecordedGoal, replay: Replay, found: Sequence[Difference]) -> None:
    """Print the comparison."""
    say = partial(print, flush=True)
    say(f"goal {goal.goal_id} on {goal.action}: {_course(replay.recorded)}")
    say(f"replayed with {len(goal.samples):,} messages of {len(goal.topics())} topics: {_course(replay.replayed)}")
    if replay.cut_at is not None:
        say(f"the recording has a gap after {replay.cut_at:.1f} s, or is too long: it is replayed up to there")
    for difference in found:
        say(difference)
    if not found:
        say("it takes the same course")


def _course(course: Course) -> str:
    stages = ", ".join(f"{stage} at {at:.1f} s" for at, stage in course.stages)
    end = f"{course.end} {course.error_code}".strip() or "no end"
    return f"{stages or 'no stage'}; {end} at {course.ended_at:.1f} s"


if __name__ == "__main__":
    sys.exit(main())

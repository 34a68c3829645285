"""The dock simulator for tests: in the test process, and what a test does to it over ROS."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool, Trigger

from docking.core.geometry import Pose, yaw_of
from docking.nodes.simulator import DockSimulator
from docking.ros.geometry import pose_message
from docking.ros.process import Spinner
from tests.support.observer import Observer, Recording, ros_nodes
from tests.support.waiting import wait_until

# Where a robot starts by default.
START = Pose(-1.5, 0.4, -0.3)


@contextmanager
def dock_simulator(domain: int, *parameters: str) -> Iterator[DockSimulator]:
    """The simulator in the test process.

    Args:
        domain: The ROS domain.
        parameters: As on the command line: `name:=value`.
    """
    arguments = [text for parameter in parameters for text in ("-p", parameter)]
    with ros_nodes(domain, *arguments) as context:
        simulator = DockSimulator(context=context)
        with Spinner(context, [simulator]) as spinner:
            yield simulator
        assert spinner.failure is None


class SimulatorControls:
    """What a test does to a simulator, by its topics and services alone."""

    def __init__(self, observer: Observer, namespace: str = "") -> None:
        """Find the simulator.

        Args:
            observer: The test's node.
            namespace: Of the robot, with its slash; empty for the root.
        """
        self._observer = observer
        self._namespace = namespace
        self._diagnostics = observer.record(DiagnosticArray, "/diagnostics")

    def place(self, pose: Pose, frame: str = "world") -> None:
        """Lift the robot and set it down."""
        message = PoseWithCovarianceStamped()
        message.header.frame_id = frame
        message.pose.pose = pose_message(pose)
        self._observer.publish(message, f"{self._namespace}/initialpose")

    def reset(self) -> None:
        """Begin again."""
        assert self._call(Trigger, "dock_simulator/reset", Trigger.Request()).success

    def switch(self, fault: str, on: bool = True) -> None:
        """Switch a fault."""
        assert self._call(SetBool, f"dock_simulator/faults/{fault}", SetBool.Request(data=on)).success

    def set_parameter(self, name: str, value: float) -> str:
        """Set a parameter; the reason why it was refused, empty where it was not."""
        return self._observer.set_parameter(f"{self._namespace}/dock_simulator", name, value)

    def _call(self, service_type: type, name: str, request: Any) -> Any:
        return self._observer.request(service_type, f"{self._namespace}/{name}", request)

    @property
    def status(self) -> dict[str, str]:
        """The key values of the last status; empty before the first."""
        name = f"{self._namespace}/dock_simulator".lstrip("/")
        for message in reversed(self._diagnostics.messages):
            for status in message.status:
                if status.name == name:
                    return {pair.key: pair.value for pair in status.values}
        return {}

    def wait_for_status(self, **expected: str) -> None:
        """Wait until the last status has these values."""
        wait_until(lambda: expected.items() <= self.status.items(), f"the status {expected}")


def pose_of(message: Odometry) -> Pose:
    """Where the robot is."""
    position, turn = message.pose.pose.position, message.pose.pose.orientation
    return Pose(position.x, position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))


def near(message: Odometry, pose: Pose) -> bool:
    """Whether it is within 1 cm and 0.02 rad of a pose."""
    here = pose_of(message)
    return here.distance_to(pose) < 0.01 and abs(math.remainder(here.theta - pose.theta, math.tau)) < 0.02


def moving(message: Odometry) -> bool:
    """Whether it drives or turns."""
    return message.twist.twist.linear.x != 0.0 or message.twist.twist.angular.z != 0.0


def velocity(linear: float, angular: float = 0.0) -> Twist:
    """A velocity in m/s and rad/s."""
    return Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))


def wait_for_new(recording: Recording, predicate: Any = lambda message: True) -> Any:
    """Wait for a message that comes from now on."""
    return recording.wait_for(predicate, since=len(recording.messages))

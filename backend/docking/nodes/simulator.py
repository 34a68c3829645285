"""The node `dock_simulator`: a simulated robot with its dock, battery and sensors, on the topics of a real one."""

import math
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import serialize_message
from sensor_msgs.msg import BatteryState, JointState, LaserScan, Range
from std_srvs.srv import SetBool, Trigger

from docking.core.geometry import Pose
from docking.core.observation import Velocity
from docking.goal.report import Level
from docking.parameters import read_topics
from docking.ros.geometry import pose_from, stamped_pose
from docking.ros.given import given_to
from docking.ros.parameters import declare_parameters
from docking.ros.process import Spinner, StopSignals, ros_context, run_process
from docking.ros.simulator_camera import SimulatorCamera
from docking.ros.simulator_clock import SimulatorClock
from docking.ros.simulator_frames import SimulatorFrames
from docking.ros.simulator_messages import (
    MAP,
    ODOM,
    WORLD,
    BatteryMessage,
    OdometryMessage,
    RangeMessage,
    ScanMessage,
    diagnostics_message,
    joint_message,
)
from docking.ros.simulator_others import SimulatorOthers
from docking.ros.simulator_room import SimulatorRoom
from docking.ros.stop_listener import StopListener
from docking.simulation.battery_yield import BatteryYield
from docking.simulation.faults import Fault
from docking.simulation.parameters import SimulatorSettings
from docking.simulation.room import WORKSHOP
from docking.simulation.simulation import Simulation
from docking.simulation.status import Status, status_of
from robot_io.endpoints import WithoutEvents, overridable_publisher
from robot_io.qos import LATCHED, LATEST

PERIOD = 1.0 / 30.0
TICKS_PER_BATTERY_MESSAGE = 3
BATTERY_RATE = 10.0
"""Battery messages per second with that; where `battery_rate` is lower, not each measurement is published again."""
DIAGNOSTICS_PERIOD = 1.0
RECEIVERS = ("left", "center", "right")


class DockSimulator(WithoutEvents, Node):  # type: ignore[misc] # rclpy has no types
    """Drives by `cmd_vel`; publishes the sensor readings of the robot, and the ground truth.

    Everything here runs in the one thread that spins the node.

    Attributes:
        detects: Whether the camera detects the marker.
    """

    def __init__(self, *, context: Context | None = None, **options: Any) -> None:
        """Make the node.

        Args:
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
        """
        super().__init__("dock_simulator", context=context, **options)
        declare_parameters(self, SimulatorSettings, self._take_settings)
        self._room = WORKSHOP.extended(self._settings.room_extension) if self._settings.room else None
        self._others = SimulatorOthers(self, "/simulated_robots") if self._settings.shares_room else None
        self._simulation = self._make_simulation()
        self._courtesy = BatteryYield()
        self._ticks = 0
        self._driven = False
        self._own_clock = SimulatorClock(self, time.monotonic(), publishes=self._settings.publish_clock)
        self._reported: Status | None = None
        self._commands = self._commands_shown = 0
        self._make_publishers()
        self._make_subscriptions()
        self.create_service(Trigger, "dock_simulator/reset", self._reset)
        self.detects = not self._settings.switched_detector
        if self._settings.switched_detector:
            self.create_service(SetBool, "dock_simulator/detector", self._switch_detector)
        for fault in Fault:
            self.create_service(SetBool, f"dock_simulator/faults/{fault}", partial(self._switch, fault))
        # A simulated clock that stands still must not stop these.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(PERIOD, self._tick, clock=steady)
        self._diagnostics_timer = self.create_timer(DIAGNOSTICS_PERIOD, self._check_graph, clock=steady)

    @property
    def simulation(self) -> Simulation:
        """The simulated robot and what surrounds it."""
        return self._simulation

    def _take_settings(self, settings: SimulatorSettings) -> None:
        self._settings = settings

    def _make_simulation(self) -> Simulation:
        others = () if self._others is None else self._others.bodies
        return Simulation(replace(self._settings.settings, room=self._room), self._settings.seed, others)

    def _make_publishers(self) -> None:
        publisher = partial(overridable_publisher, self)
        self._odometry = publisher(Odometry, "odom")
        self._truth = publisher(Odometry, "ground_truth")
        self._marker = publisher(PoseStamped, "detected_dock_pose")
        self._ranges = [publisher(Range, f"infrared/{receiver}") for receiver in RECEIVERS]
        self._scan = publisher(LaserScan, "scan")
        self._joints = publisher(JointState, "joint_states")
        self._battery = publisher(BatteryState, "battery_status")
        self._dock = publisher(PoseStamped, "true_dock_pose", LATCHED)
        # Absolute, as REP-107 has it: one topic for all robots; the name of the status says which one.
        self._diagnostics = publisher(DiagnosticArray, "/diagnostics")
        places = self._simulation.dock.places
        home = Pose(y=places[min(self._settings.home_dock, len(places)) - 1])
        self._dock.publish(stamped_pose(home, WORLD, self._now()))
        self._world_frames = {WORLD, ""}
        mapped = self._room if self._settings.publish_map else None
        if mapped is not None:
            self._world_frames |= {MAP}
        self._on_map = SimulatorRoom(self, mapped, lambda: self._simulation)
        self._frames = SimulatorFrames(
            self,
            self._settings.odometry_child_frame,
            self._settings.detection_frame,
            self._simulation.settings.laser.mount,
            self._simulation.settings.marker.camera_yaw,
            localizes=mapped is not None,
        )
        self._camera = SimulatorCamera(self)
        self._make_messages()

    def _make_messages(self) -> None:
        infrared = self._simulation.settings.infrared
        self._odometry_message = OdometryMessage(ODOM, self._settings.odometry_child_frame.value)
        self._truth_message = OdometryMessage(WORLD)
        self._range_messages = [RangeMessage(receiver, infrared) for receiver in RECEIVERS]
        self._scan_message = ScanMessage(self._simulation.settings.laser)
        self._battery_message = BatteryMessage()
        self._battery_told = -math.inf
        self._odometry_told = self._marker_told = self._ranges_told = self._scan_told = -math.inf

    def _make_subscriptions(self) -> None:
        def subscribe(message_type: type, topic: str, callback: Any, qos: QoSProfile | int, **more: Any) -> None:
            overriding = QoSOverridingOptions.with_default_policies()
            self.create_subscription(message_type, topic, callback, qos, qos_overriding_options=overriding, **more)

        if self._settings.enable_stamped_cmd_vel:
            subscribe(TwistStamped, "cmd_vel", lambda message: self._drive(message.twist), LATEST)
        else:
            subscribe(Twist, "cmd_vel", self._drive, LATEST)
        subscribe(BatteryState, "battery_status", self._hear_battery, LATEST, raw=True)
        subscribe(PoseWithCovarianceStamped, "initialpose", self._place, 10)
        self._stops = StopListener(self, self._obey_stop)
        self._stops.listen_to(read_topics(self._settings.stop_topics))

    # Commands to the robot.

    def _drive(self, message: Twist) -> None:
        self._driven = True
        self._simulation.command(Velocity(message.linear.x, message.angular.z, message.linear.y))

    def _obey_stop(self) -> None:
        self._simulation.halted = self._stops.held
        if self._stops.held:
            self._on_map.interrupt("a stop was latched")
        self._report_change()

    def _place(self, message: PoseWithCovarianceStamped) -> None:
        frame = message.header.frame_id
        if frame not in self._world_frames:
            self.get_logger().warning(f"initialpose is in the frame {frame!r}, but must be in {WORLD}: ignored")
            return
        try:
            pose = pose_from(message.pose.pose)
        except ValueError as error:
            self.get_logger().warning(f"initialpose {error}: ignored")
            return
        self._on_map.interrupt("the robot was lifted")
        self._simulation.place(pose)
        self._commands += 1

    def _hear_battery(self, message: bytes) -> None:
        self._courtesy.heard(message, time.monotonic())

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._on_map.interrupt("the simulator was reset")
        halted = self._simulation.halted
        self._simulation = self._make_simulation()
        self._simulation.halted = halted
        self._make_messages()
        self._commands += 1
        response.success = True
        response.message = "the robot is at its start pose"
        self.get_logger().info("Reset: the robot is at its start pose")
        return response

    def _switch(self, fault: Fault, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._simulation.set_fault(fault, request.data)
        self._commands += 1
        response.success = True
        response.message = f"{fault} is {'on' if request.data else 'off'}"
        self.get_logger().info(f"Fault {response.message}")
        return response

    def _switch_detector(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self.detects = request.data
        response.success = True
        response.message = f"the detector is {'on' if request.data else 'off'}"
        self.get_logger().info(f"The detector is {'on' if request.data else 'off'}")
        return response

    # Time passes.

    def _tick(self) -> None:
        now = time.monotonic()
        lapse = self._own_clock.step(now, driven=self._driven or self._on_map.drives)
        self._driven = False
        self._simulation.scanning = self._scan.get_subscription_count() > 0
        self._on_map.drive()
        self._simulation.run(lapse * self._settings.real_time_factor)
        if self._others is not None:
            self._others.step(self._simulation, self._now())
        self._commands_shown = self._commands  # not before: what touches and charges is known once time has passed
        self._publish()
        if self._ticks % TICKS_PER_BATTERY_MESSAGE == 0:
            self._publish_battery(now)
        self._ticks += 1
        self._report_change()

    def _publish(self) -> None:
        simulation, stamp = self._simulation, self._now()
        reading, robot = simulation.reading, simulation.robot
        if reading is not None and reading[1].stamp > self._odometry_told:
            odometry = reading[1]
            self._odometry_told = odometry.stamp  # of its arrival: its message may repeat the one before
            reckoned = self._stamp(reading[0])
            self._odometry.publish(self._odometry_message.fill(odometry.pose, odometry.velocity, reckoned))
            self._frames.publish(odometry.pose, simulation.located_origin, simulation.time, reckoned)
        if self._joints.get_subscription_count() > 0:
            self._joints.publish(joint_message(simulation.wheels, stamp))
        self._truth.publish(self._truth_message.fill(robot.pose, robot.velocity, stamp))
        detections, ranges = simulation.detections, simulation.ranges
        if self.detects and detections and detections[0][0] != self._marker_told:
            self._marker_told = detections[0][0]
            for _, marker in detections:
                self._marker.publish(self._frames.detection(marker, self._stamp(self._marker_told)))
        if ranges is not None and ranges[0] > self._ranges_told:
            self._ranges_told, seen = ranges
            distances = (seen.left, seen.center, seen.right)
            measured = self._stamp(self._ranges_told)
            for publisher, message, distance in zip(self._ranges, self._range_messages, distances, strict=True):
                publisher.publish(message.fill(distance, measured))

        scan = simulation.scan
        if scan is not None and scan.stamp > self._scan_told:
            self._scan_told = scan.stamp
            self._scan.publish(self._scan_message.fill(scan.distances, self._stamp(scan.stamp)))
        self._camera.publish(simulation, stamp)

    def _publish_battery(self, now: float) -> None:
        """Publish the state of the battery, unless someone else does or it is silent."""
        if self._others_publish_battery(now) or Fault.SILENT_BATTERY in self._simulation.faults:
            return
        measured = self._simulation.measurement
        repeats = measured is not None and measured[1] == self._battery_told
        if measured is not None and not (repeats and self._simulation.settings.battery.battery_rate < BATTERY_RATE):
            self._battery_told = measured[1]
            message = serialize_message(self._battery_message.fill(measured[0], self._now()))
            self._courtesy.sent(message)
            self._battery.publish(message)

    def _others_publish_battery(self, now: float) -> bool:
        return self._courtesy.others_publish(now, self._settings.battery_resume_after)

    # Its status.

    def _stamp(self, time: float) -> Any:
        """A moment of the simulation, as a stamp."""
        return self._own_clock.stamp((self._simulation.time - time) / self._settings.real_time_factor)

    def _now(self) -> Any:
        return self._own_clock.stamp()

    def _status(self) -> Status:
        others = self._others_publish_battery(time.monotonic())
        return status_of(
            self._simulation,
            battery_publisher="other" if others else "self",
            real_time_factor=self._settings.real_time_factor * self._own_clock.rate,
            too_slow=not self._own_clock.keeps_up,
            commands=self._commands_shown,
        )

    def _report_change(self) -> None:
        status, before = self._status(), self._reported
        if status == before:
            return
        if before is not None and status.battery_publisher != before.battery_publisher:
            others = status.battery_publisher == "other"
            self.get_logger().info(
                "Another node publishes battery_status: pausing" if others else "Publishing battery_status again"
            )
        self._report()

    def _check_graph(self) -> None:
        self._stops.scan()
        self._report()

    def _report(self) -> None:
        status = self._reported = self._status()
        level = Level.WARN if status.faults or status.halted else Level.OK
        name = self.get_fully_qualified_name()[1:]
        self._diagnostics.publish(diagnostics_message(name, level, status.message, status.values(), self._now()))

    def destroy_node(self) -> None:
        """Leave the ROS graph, with an action server, which rclpy would leave behind."""
        self._on_map.close()
        super().destroy_node()


def _run(args: Sequence[str] | None) -> int:
    signals = StopSignals()
    with ros_context(args) as context:
        simulator = DockSimulator(context=context)
        simulator.get_logger().info("Simulating a robot and its dock...")
        given_to(context).warn([simulator])
        with Spinner(context, [simulator], on_failure=signals.wake) as spinner:
            signals.wait()
        return 0 if spinner.failure is None else 1


def main(args: Sequence[str] | None = None) -> int:
    """Run the simulator until SIGINT or SIGTERM.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where a parameter is wrong.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())

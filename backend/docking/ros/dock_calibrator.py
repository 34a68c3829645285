"""The service `calibrate_dock`: measures where the docked robot stands, as seen from the marker."""

import math
from collections.abc import Callable, Sequence

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.service import Service
from rclpy.task import Future
from std_srvs.srv import Trigger

from docking.core.battery import Battery
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.core.transform import tilt
from docking.estimation.calibration import Calibration, CalibrationError, DockCalibration
from docking.parameters import Dock, DockDirection
from docking.ros.active_goal import ActiveGoal
from docking.ros.clock import control_time
from docking.ros.sensors import Sensor, Sensors
from docking.ros.transforms import Transforms
from robot_io.transform import Transform

SERVICE = "calibrate_dock"
PARAMETERS = (
    "external_detection_translation_x",
    "external_detection_translation_y",
    "external_detection_rotation_yaw",
)
"""The measured parameters: x, y and theta of the docked robot in the marker's frame."""
TILT = ("external_detection_rotation_roll", "external_detection_rotation_pitch")
DIGITS = 4
PERIOD = 0.05
NEEDED = frozenset({Sensor.ODOMETRY, Sensor.MARKER})


class DockCalibrator:
    """Measures for some seconds, sets the parameters, and answers with them as YAML.

    Nothing moves the robot meanwhile: a goal that arrives ends the measurement. All calls must come from the thread
    that spins the node.
    """

    def __init__(
        self,
        node: Node,
        battery: Battery,
        transforms: Transforms,
        active_goal: ActiveGoal,
        dock_types: Callable[[], Sequence[str]],
    ) -> None:
        """Start without the service.

        Args:
            node: The node that has the parameters.
            battery: Where the battery subscriber puts its readings.
            transforms: How frames lie in each other.
            active_goal: Of all servers that drive this robot.
            dock_types: The types of docks that have parameters of their own.
        """
        self._node = node
        self._battery = battery
        self._active_goal = active_goal
        self._dock_types = dock_types
        self._names: tuple[str, ...] = PARAMETERS
        self._offered = False
        self._unanswered = 0
        self._service: Service | None = None
        self._sensors = Sensors(node, transforms, lambda: None)
        self._measurement: DockCalibration | None = None
        self._ended = Future()
        self._timer = node.create_timer(PERIOD, self._step, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._timer.cancel()
        self._group = ReentrantCallbackGroup()  # a second request is refused while the first one waits

    def switch(self, *, on: bool) -> None:
        """Offer the service or not."""
        self._offered = on
        if on and self._service is None:
            self._service = self._node.create_service(Trigger, SERVICE, self._calibrate, callback_group=self._group)
        elif not on and self._service is not None:
            self.close()
            self._withdraw()

    def _withdraw(self) -> None:
        """Destroy the service if it is not offered any more, and has answered."""
        if self._service is not None and not self._offered and not self._unanswered:
            self._node.destroy_service(self._service)
            self._service = None

    def close(self) -> None:
        """End the running measurement."""
        self._refuse("the server no longer calibrates")

    async def _calibrate(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._active_goal.running is not None:
            response.message = "a goal is running: calibrate while the robot stands on its dock"
        elif self._measurement is not None:
            response.message = "a calibration is running"
        elif (dock_type := self._active_goal.memory.type_among(self._dock_types())) is None:
            response.message = "there are several types of docks: let a goal dock the robot, to tell which one it is on"
        else:
            self._names = _of_type(dock_type, PARAMETERS)
            self._measurement = DockCalibration(control_time(self._node))
            self._ended = Future()
            self._sensors.marker_tilt = self._tilt(dock_type)
            try:
                self._sensors.listen_to(NEEDED)
                self._timer.reset()
            except Exception as error:  # noqa: BLE001 - such as a `qos_overrides` parameter that is wrong
                self._refuse(f"{type(error).__name__}: {error}")
            self._unanswered += 1
            response.success, response.message = await self._ended
            self._unanswered -= 1
            assert self._node.executor is not None
            self._node.executor.create_task(self._withdraw)  # it runs after the answer was sent
        if response.success:
            self._node.get_logger().info(f"The dock is calibrated:\n{response.message}")
        else:
            self._node.get_logger().warning(f"The dock is not calibrated: {response.message}")
        return response

    def _tilt(self, dock_type: str) -> Transform:
        return tilt(*(self._node.get_parameter(name).value for name in _of_type(dock_type, TILT)))

    def _step(self) -> None:
        if self._measurement is None:
            return
        if self._active_goal.running is not None:
            self._refuse("a goal has arrived")
            return
        observation = self._sensors.observe(self._battery.latest)
        try:
            result = self._measurement.step(observation)
        except CalibrationError as error:
            self._refuse("; ".join([str(error), *self._sensors.faults.values()]))
        else:
            if result is not None:
                self._apply(result, observation)

    def _apply(self, result: Calibration, observation: Observation) -> None:
        docked, direction = result.docked, self._names[0].replace(PARAMETERS[0], "dock_direction")
        if self._node.get_parameter(direction).value == DockDirection.BACKWARD:
            docked = docked.compose(Pose(theta=math.pi))  # the parameters describe a robot that faces its dock
        docked = Dock.offset(docked)
        before = Pose(*(self._node.get_parameter(name).value for name in self._names))
        values = [round(value, DIGITS) for value in (docked.x, docked.y, docked.theta)]
        answer = self._node.set_parameters_atomically(
            [Parameter(name, value=value) for name, value in zip(self._names, values, strict=True)]
        )
        if not answer.successful:
            self._refuse(f"the measured values {values} cannot be set: {answer.reason}")
            return
        noise = f"{1000.0 * result.distance_noise:.0f} mm and {math.degrees(result.angle_noise):.1f}°"
        remarks = [f"{result.count} detections in {result.seconds:.0f} s; standard deviation {noise}."]
        if observation.battery is None or not observation.battery.connected:
            remarks.append("The battery's status is not CHARGING: check that the robot is on its dock.")
        remarks.append("The values are in use until the node ends. To keep them, write them into its parameter file.")
        self._end(True, _yaml(self._node.get_fully_qualified_name(), remarks, self._names, values, before))

    def _refuse(self, reason: str) -> None:
        self._end(False, reason)

    def _end(self, success: bool, message: str) -> None:
        if self._measurement is None:
            return
        self._measurement = None
        self._timer.cancel()
        self._sensors.listen_to(frozenset())
        self._ended.set_result((success, message))


def _of_type(dock_type: str, names: Sequence[str]) -> tuple[str, ...]:
    """The names of parameters of a type of docks."""
    return tuple(f"{dock_type}.{name}" if dock_type else name for name in names)


def _yaml(node: str, remarks: list[str], names: Sequence[str], values: list[float], before: Pose) -> str:
    """A parameter file of the values; its comments say how they were before."""
    lines = [f"# {remark}" for remark in remarks]
    lines += [f"{node}:", "  ros__parameters:"]
    for name, value, old in zip(names, values, (before.x, before.y, before.theta), strict=True):
        lines.append(f"    {name}: {value!r}  # before: {old!r}")
    return "\n".join(lines)

"""A node `/robot1/base` with services, parameters and a velocity topic, some of which misbehave.

Services: `echo` answers, `never` and `leave` do not, `huge` answers with 2 MB. It prints `driven at SPEED` for each
message on `cmd_vel`, and `heard TEXT` for each on `chatter`; at the text `leave` the service of that name is destroyed.
"""

import contextlib
import math
from typing import Any

import rclpy
from diagnostic_msgs.srv import SelfTest
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

HUGE = 2_000_000


class Base(Node):  # type: ignore[misc]
    """The node."""

    def __init__(self) -> None:
        super().__init__("base", namespace="/robot1")
        self.create_service(SetBool, "echo", self._echo)
        self.create_service(SelfTest, "huge", self._huge)
        self.create_subscription(Twist, "cmd_vel", lambda heard: print("driven at", heard.linear.x, flush=True), 10)
        self.create_subscription(String, "chatter", self._hear, 10)
        self._idle = rclpy.create_node("idle", namespace="/robot1")  # it is not spun
        self._idle.create_service(Trigger, "never", lambda _, response: response)
        self._leaving = self._idle.create_service(Trigger, "leave", lambda _, response: response)
        speed = FloatingPointRange(from_value=0.0, to_value=1.0, step=0.1)
        count = IntegerRange(from_value=0, to_value=10, step=5)
        self.declare_parameter("speed", 0.5, ParameterDescriptor(description="In m/s", floating_point_range=[speed]))
        self.declare_parameter("count", 5, ParameterDescriptor(integer_range=[count]))
        self.declare_parameter("fixed", "as it is", ParameterDescriptor(read_only=True))
        self.declare_parameter("free", 1, ParameterDescriptor(dynamic_typing=True))
        self.declare_parameter("limit", 2**63 - 1)
        self.declare_parameter("unmeasured", math.nan)
        self.declare_parameter("raw", [b"\x00", b"\xff"])
        self.declare_parameter("names", ["a", "b"])
        self.declare_parameter("offset", Parameter.Type.DOUBLE)
        self.declare_parameter("odd.name-with spaces/ü", True)
        self.add_on_set_parameters_callback(self._check)

    def _hear(self, message: String) -> None:
        print("heard", message.data, flush=True)
        if message.data == "leave":
            self._idle.destroy_service(self._leaving)

    @staticmethod
    def _check(parameters: list[Parameter]) -> SetParametersResult:
        refused = any(parameter.name == "names" and "bad" in parameter.value for parameter in parameters)
        return SetParametersResult(successful=not refused, reason="bad is not a name" if refused else "")

    @staticmethod
    def _echo(request: Any, response: Any) -> Any:
        response.success, response.message = request.data, "echoed"
        return response

    @staticmethod
    def _huge(_: Any, response: Any) -> Any:
        response.id = "x" * HUGE
        return response


def main() -> None:
    rclpy.init()
    node = Base()
    print("serving", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()

"""A ROS node that floods whoever listens, in one way each: `python -m tests.support.hostile_node MODE [options]`.

It prints `flooding` once it has begun, and goes on until it is ended.
"""

import argparse
import contextlib
import itertools
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_action_status_default
from rclpy.serialization import serialize_message
from sensor_msgs.msg import BatteryState
from test_msgs.action import Fibonacci as OtherFibonacci
from unique_identifier_msgs.msg import UUID

from action_tutorials_interfaces.action import ConnectToChargingDock, Fibonacci

FeedbackMessage = ConnectToChargingDock.Impl.FeedbackMessage
RELIABLE = QoSProfile(depth=10)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Bytes of a goal id, and where ids are in encoded messages: in feedback, the first and the second in a status, and the
# distance of the others.
ID_SIZE, ID_OF_FEEDBACK, FIRST_ID, SECOND_ID, NEXT_ID = 16, 4, 8, 33, 28
# Seconds for which silent servers are not silent yet.
ANSWERING_FOR = 10.0

Mode = Callable[[Node, argparse.Namespace], Callable[[], None]]


def new_id() -> UUID:
    return UUID(uuid=list(os.urandom(16)))


def entry(goal_id: UUID, status: int = GoalStatus.STATUS_EXECUTING) -> GoalStatus:
    found = GoalStatus(status=status)
    found.goal_info.goal_id = goal_id
    found.goal_info.stamp.sec = int(time.time())
    return found


def feedback_of(goal_id: UUID, size: int = 0) -> Any:
    """A feedback message with so many bytes in it."""
    message = FeedbackMessage(goal_id=goal_id)
    message.feedback.current_battery_state.cell_voltage = [3.7] * (size // 4)
    return message


def status_entries(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """One status message with thousands of goals that run, again and again."""
    publisher = _status_publisher(node, options.action)
    message = GoalStatusArray(status_list=[entry(new_id()) for _ in range(options.count)])
    return lambda: publisher.publish(message)


def ended_entries(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """The same with goals that have ended."""
    publisher = _status_publisher(node, options.action)
    ended = [entry(new_id(), GoalStatus.STATUS_SUCCEEDED) for _ in range(options.count)]
    return lambda: publisher.publish(GoalStatusArray(status_list=ended))


def unknown_goals(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Status and feedback of a goal that nobody has heard of, another one each time."""
    status, feedback = _status_publisher(node, options.action), _feedback_publisher(node, options.action)

    def flood() -> None:
        goal_id = new_id()
        status.publish(GoalStatusArray(status_list=[entry(goal_id)]))
        feedback.publish(feedback_of(goal_id))

    return flood


def unknown_feedback(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Feedback of a goal that nobody has heard of and no status names, another one each time."""
    publisher = _feedback_publisher(node, options.action)
    return _with_new_ids(publisher, serialize_message(feedback_of(new_id(), options.size)), [ID_OF_FEEDBACK])


def unknown_statuses(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Status of many goals that nobody has heard of, others each time."""
    publisher = _status_publisher(node, options.action)
    message = GoalStatusArray(status_list=[entry(new_id()) for _ in range(options.count)])
    places = [FIRST_ID, *(SECOND_ID + NEXT_ID * number for number in range(options.count - 1))]
    return _with_new_ids(publisher, serialize_message(message), places)


def _with_new_ids(publisher: Any, message: bytes, places: list[int]) -> Callable[[], None]:
    """Publish an encoded message, with other goal ids each time. Much faster than to make the message."""

    def flood() -> None:
        data, ids = bytearray(message), os.urandom(ID_SIZE * len(places))
        for number, place in enumerate(places):
            data[place : place + ID_SIZE] = ids[ID_SIZE * number : ID_SIZE * (number + 1)]
        publisher.publish(bytes(data))

    return flood


def churn(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Topics and actions that come and go."""
    made: deque[Any] = deque()
    numbers = itertools.count()

    def flood() -> None:
        name = f"/churn{next(numbers)}"
        made.append(node.create_publisher(BatteryState, f"{name}/battery_status", RELIABLE))
        made.append(_status_publisher(node, f"{name}/connect_to_charging_dock"))
        while len(made) > options.count:
            node.destroy_publisher(made.popleft())

    return flood


def big_feedback(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Feedback of one goal, of so many bytes."""
    status, feedback = _status_publisher(node, options.action), _feedback_publisher(node, options.action)
    goal_id = UUID(uuid=list(bytes(15) + b"\1"))
    running, message = GoalStatusArray(status_list=[entry(goal_id)]), feedback_of(goal_id, options.size)

    def flood() -> None:
        status.publish(running)
        feedback.publish(message)

    return flood


def feedback(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Small feedback of one goal, as fast as it goes."""
    options.size = options.size or 16
    return big_feedback(node, options)


def battery(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Battery states."""
    publisher = node.create_publisher(BatteryState, options.topic or "/battery_status", RELIABLE)
    message = BatteryState(voltage=12.0, percentage=0.5, cell_voltage=[3.7] * (options.size // 4))
    return lambda: publisher.publish(message)


def velocity(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Velocities."""
    publisher = node.create_publisher(Twist, options.topic or "/cmd_vel", RELIABLE)
    return lambda: publisher.publish(Twist())


def diagnostics(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Diagnostics, of so many statuses, of goals that nobody has heard of."""
    publisher = node.create_publisher(DiagnosticArray, options.topic or "/diagnostics", RELIABLE)
    numbers = itertools.count()

    def flood() -> None:
        values = [("goal_id", f"{next(numbers)}"), ("error_code", "NOISE"), ("stage", "ABORTED"), ("retries", "1")]
        pairs = [KeyValue(key=key, value=value) for key, value in values]
        publisher.publish(DiagnosticArray(status=[DiagnosticStatus(name="noise", values=pairs)] * options.count))

    return flood


def grid(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """A map of so many bytes that is never the same, and a battery: its robot is known."""
    publisher = node.create_publisher(OccupancyGrid, options.topic or "/map", LATCHED)
    node.create_publisher(BatteryState, "/battery_status", RELIABLE)
    message = OccupancyGrid()
    message.header.frame_id = "map"
    message.info.resolution, message.info.width = 0.05, 1000
    message.info.height = options.size // message.info.width
    message.info.origin.orientation.w = 1.0
    cells = os.urandom(options.size)  # a photograph rather than a room: it hardly compresses
    message.data.frombytes(bytes(min(cell % 128, 100) for cell in cells))

    def flood() -> None:
        message.data[0] = (message.data[0] + 1) % 100
        publisher.publish(message)

    return flood


def actions(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Hundreds of actions at once, of which only the topics are there."""
    for number in range(options.count):
        _publish_topics(node, f"/hostile{number}/connect_to_charging_dock", ConnectToChargingDock)
    return lambda: None


def silent_servers(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Action servers that answer for some seconds, and from then on only send feedback."""
    impl, floods = ConnectToChargingDock.Impl, []
    silent_from = time.monotonic() + ANSWERING_FOR

    def serve(_: Any, response: Any) -> Any:
        if time.monotonic() > silent_from:
            threading.Event().wait()
        return response

    for number in range(options.count):
        options.action = f"/silent{number}/connect_to_charging_dock"
        floods.append(feedback(node, options))
        services = {"send_goal": impl.SendGoalService, "get_result": impl.GetResultService, "cancel_goal": CancelGoal}
        for name, kind in services.items():
            node.create_service(kind, f"{options.action}/_action/{name}", serve)

    def flood() -> None:
        for send in floods:
            send()

    return flood


def robots(node: Node, options: argparse.Namespace) -> Callable[[], None]:
    """Hundreds of batteries at once."""
    for number in range(options.count):
        node.create_publisher(BatteryState, f"/hostile{number}/battery_status", RELIABLE)
    return lambda: None


def odd_actions(node: Node, _: argparse.Namespace) -> Callable[[], None]:
    """Actions of types that do not work everywhere, of two types at once, and with a name of 200 characters."""
    _publish_topics(node, "/a_first/other", OtherFibonacci)
    _publish_topics(node, "/b_second/two_types", Fibonacci)
    another = Context()  # a process cannot have a topic with two types in one
    rclpy.init(context=another)
    _publish_topics(rclpy.create_node("another", context=another), "/b_second/two_types", OtherFibonacci)
    _publish_topics(node, f"/c_third/{'long' * 45}", Fibonacci)
    _publish_topics(node, "/d_fourth/_action/_action/feedback", Fibonacci)
    return lambda: None


MODES: dict[str, Mode] = {
    mode.__name__: mode
    for mode in (
        status_entries,
        ended_entries,
        unknown_goals,
        unknown_feedback,
        unknown_statuses,
        churn,
        big_feedback,
        feedback,
        battery,
        velocity,
        diagnostics,
        grid,
        actions,
        silent_servers,
        robots,
        odd_actions,
    )
}


def _status_publisher(node: Node, action: str) -> Any:
    return node.create_publisher(GoalStatusArray, f"{action}/_action/status", qos_profile_action_status_default)


def _feedback_publisher(node: Node, action: str, action_type: Any = ConnectToChargingDock) -> Any:
    return node.create_publisher(action_type.Impl.FeedbackMessage, f"{action}/_action/feedback", RELIABLE)


def _publish_topics(node: Node, action: str, action_type: Any) -> None:
    _status_publisher(node, action)
    _feedback_publisher(node, action, action_type)


def _turns(rate: float) -> Iterator[None]:
    """So many a second; late ones are made up for at once."""
    began = time.monotonic()
    for turn in itertools.count():
        time.sleep(max(0.0, began + turn / rate - time.monotonic()))
        yield


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("mode", choices=MODES)
    parser.add_argument("--rate", type=float, default=1.0, help="messages a second")
    parser.add_argument("--count", type=int, default=1, help="entries of a message, or how many at once")
    parser.add_argument("--size", type=int, default=0, help="bytes of a message")
    parser.add_argument("--action", default="/connect_to_charging_dock")
    parser.add_argument("--topic", default="")
    options = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node(f"hostile_{options.mode}")
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        flood = MODES[options.mode](node, options)
        threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        time.sleep(1.0)  # until whoever listens is found
        print("flooding", flush=True)
        for _ in _turns(options.rate):
            flood()


if __name__ == "__main__":
    main()
